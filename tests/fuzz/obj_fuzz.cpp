// Reading any bytes as OBJ gives a cloud or an error, and no more points than bytes.
#include "tests/fuzz/read_points.h"

FUZZ_TARGET(obj) { require(read_points(input, CloudFormat::obj) <= input.size()); }
