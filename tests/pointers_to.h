#pragma once

#include <span>
#include <vector>

#include "pointreel/cloud.h"

namespace pointreel {

/// As encode_video_group() takes clouds, which must outlive the pointers.
inline std::vector<const PointCloud*> pointers_to(std::span<const PointCloud> clouds) {
  std::vector<const PointCloud*> pointers;
  for (const PointCloud& cloud : clouds) pointers.push_back(&cloud);
  return pointers;
}

}  // namespace pointreel
