// Reading any bytes as numpy's arrays gives a cloud or an error, within the limits.
#include "tests/fuzz/read_points.h"

FUZZ_TARGET(numpy) { require(read_points(input, CloudFormat::numpy) <= 1u << 20); }
