// Reading any bytes as intrinsics with pictures of depth and colours gives a cloud within the
// limits, or an error.
#include "tests/fuzz/read_points.h"

FUZZ_TARGET(depth_frame) { require(read_points(input, CloudFormat::depth_frame) <= (1u << 20)); }
