// Reading any bytes as lines of numbers gives a cloud or an error, and no more points than bytes.
#include "tests/fuzz/read_points.h"

FUZZ_TARGET(text_points) { require(read_points(input, CloudFormat::text) <= input.size()); }
