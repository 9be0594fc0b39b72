// Reading any bytes as PCD gives a cloud or an error, and no more points than bytes could stand
// for.
#include "tests/fuzz/read_points.h"

FUZZ_TARGET(pcd) { require(read_points(input, CloudFormat::pcd) <= 100 * input.size()); }
