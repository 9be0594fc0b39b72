#pragma once

#include <memory>
#include <utility>

#include "client/scene/frame.h"

namespace pointreel {

/// A frame of a cloud alone, without a tree.
inline std::shared_ptr<const SceneFrame> cloud_frame(PointCloud cloud) {
  auto frame = std::make_shared<SceneFrame>();
  frame->cloud = std::move(cloud);
  return frame;
}

}  // namespace pointreel
