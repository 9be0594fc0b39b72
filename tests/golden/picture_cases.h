#pragma once

#include <memory>
#include <string>
#include <vector>

#include "client/render/opengl/gl_renderer.h"

namespace pointreel::golden {

/// A picture that is kept in the repository.
struct PictureCase {
  std::string name;
  std::shared_ptr<const SceneFrame> frame;
  Camera camera;
  DrawOptions options;
};

inline constexpr glm::ivec2 kPictureSize(144, 112);

/// A ball that a tilted sheet passes through, made of 320 surfels. Neighbours have different,
/// strong colours, and the normals of a few surfels are unknown.
PointCloud picture_cloud();

/// The index of the surfel of `picture_cloud` that covers most of the picture's middle.
std::size_t middle_surfel();

/// All ways of drawing `cloud`, which is picture_cloud() or a variant of it. The names are the same
/// for every cloud.
std::vector<PictureCase> picture_cases(const PointCloud& cloud);

}  // namespace pointreel::golden
