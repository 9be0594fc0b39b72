#pragma once

#include <memory>
#include <string>
#include <vector>

#include "client/render/renderer.h"

namespace pointreel::golden {

/// A picture that is kept.
struct PictureCase {
  std::string name;
  std::shared_ptr<const SceneFrame> frame;
  Camera camera;
  DrawOptions options;
};

inline constexpr glm::ivec2 kPictureSize(144, 112);

/// A ball that a tilted sheet passes through, of 320 surfels in strong colours that neighbours do
/// not share, a few of them without a known normal.
PointCloud picture_cloud();

/// The index of the surfel of `picture_cloud` that covers the most of the picture's middle.
std::size_t middle_surfel();

/// Every way to draw, of `cloud`, which is picture_cloud() or a changed one. Names are the same
/// for every cloud.
std::vector<PictureCase> picture_cases(const PointCloud& cloud);

}  // namespace pointreel::golden
