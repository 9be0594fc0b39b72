// Reading any bytes as a message of ROS 2 gives a cloud or an error, and no more points than bytes.
#include "tests/fuzz/read_points.h"

FUZZ_TARGET(point_cloud2) {
  require(read_points(input, CloudFormat::point_cloud2) <= input.size());
}
