// Reading any bytes as LAS gives a cloud or an error, and no more points than bytes.
#include "tests/fuzz/read_points.h"

FUZZ_TARGET(las) { require(read_points(input, CloudFormat::las) <= input.size()); }
