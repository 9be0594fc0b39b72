// Reading any bytes as a sweep of KITTI or nuScenes gives a cloud or an error, and no more points
// than bytes.
#include "tests/fuzz/read_points.h"

FUZZ_TARGET(sweep) {
  require(read_points(input, CloudFormat::sweep) <= input.size());
  require(read_points(input, CloudFormat::nuscenes_sweep) <= input.size());
}
