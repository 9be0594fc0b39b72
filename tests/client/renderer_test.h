#pragma once

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <utility>

#include "client/prepare/strip_frame.h"
#include "codec/core/build.h"
#include "tests/client/drawing_test.h"

namespace pointreel {

inline constexpr glm::ivec2 kSize(240, 180);
inline constexpr glm::u16vec3 kRed(0xffff, 0, 0), kGreen(0, 0xffff, 0), kBlue(0, 0, 0xffff),
    kOrange(0xffff, 0x8080, 0x2020);
inline constexpr glm::vec3 kFront(0.0f, 0.0f, 1.0f);

inline int difference(const glm::u8vec3& a, const glm::u8vec3& b) {
  return std::max({std::abs(a.x - b.x), std::abs(a.y - b.y), std::abs(a.z - b.z)});
}

inline glm::u8vec3 eight_bits(const glm::u16vec3& c) { return glm::u8vec3(c / std::uint16_t{257}); }

inline int largest_difference(const Image& a, const Image& b) {
  if (a.pixels.size() != b.pixels.size()) return 256;
  int largest = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    largest = std::max(largest, difference(a.pixels[i], b.pixels[i]));
  }
  return largest;
}

inline std::size_t count_near(const Image& image, const glm::u8vec3& color, int within = 3) {
  return static_cast<std::size_t>(
      std::count_if(image.pixels.begin(), image.pixels.end(),
                    [&](const glm::u8vec3& p) { return difference(p, color) <= within; }));
}

inline void add(PointCloud& cloud, const glm::vec3& p, const glm::vec3& n,
                const glm::u16vec3& color, float radius) {
  cloud.positions.push_back(p);
  cloud.normals.push_back(n);
  cloud.colors.push_back(color);
  cloud.radii.push_back(radius);
}

inline std::shared_ptr<SceneFrame> frame_of(PointCloud cloud, int depth = 5) {
  auto frame = std::make_shared<SceneFrame>();
  frame->cloud = std::move(cloud);
  // All voxels share one cube, so that the place of a voxel does not depend on the other points.
  const SortedPoints sorted = sort_points(frame->cloud, {frame->cloud.origin - 1.5, 3.0});
  frame->svo = build_svo(sorted, depth);
  frame->attributes = mean_attributes(frame->svo, frame->cloud, sorted);
  return frame;
}

/// The same cloud as triangle strips.
inline std::shared_ptr<SceneFrame> strip_frame_of(PointCloud cloud) {
  auto frame = std::make_shared<SceneFrame>();
  frame->cloud = std::move(cloud);
  make_strips(*frame, {});
  return frame;
}

/// Four colours, none on the boundary of a voxel. A mirrored axis or a rotation would put no colour
/// at the place of another.
inline PointCloud asymmetric_cloud() {
  PointCloud cloud;
  add(cloud, {0.8f, 0.14f, 0.04f}, kFront, kRed, 0.1f);
  add(cloud, {0.23f, 0.7f, 0.04f}, kFront, kGreen, 0.1f);
  add(cloud, {-0.52f, -0.42f, 0.24f}, kFront, kBlue, 0.1f);
  add(cloud, {0.04f, 0.04f, 0.04f}, kFront, kOrange, 0.1f);
  return cloud;
}

inline Camera front_camera() {
  Camera camera;
  camera.distance = 4.0;
  return camera;
}

/// The pixel in which a world point lies, computed independently of the renderer.
inline glm::ivec2 pixel_of(const Camera& camera, const glm::dvec3& world, glm::ivec2 size = kSize) {
  const glm::dvec3 e = glm::transpose(camera.axes()) * (world - camera.eye());
  const double f = 0.5 * size.y / std::tan(0.5 * camera.fov_y);
  return glm::ivec2(glm::floor(glm::dvec2(0.5 * size.x + f * e.x / -e.z,  //
                                          0.5 * size.y - f * e.y / -e.z)));
}

inline DrawOptions plain(DrawMode mode) {
  DrawOptions options;
  options.mode = mode;
  options.lighting = false;
  options.point_size = 5.0f;
  options.adaptive_points = false;
  options.background = glm::vec3(0.2f, 0.4f, 0.6f);
  return options;
}

inline const glm::u8vec3 kBackground(51, 102, 153);
inline constexpr DrawMode kModes[] = {DrawMode::surfel, DrawMode::voxel, DrawMode::point};

class RendererTest : public DrawingTest {
 protected:
  Image picture(const std::shared_ptr<const SceneFrame>& frame, const Camera& camera,
                const DrawOptions& options, glm::ivec2 size = kSize) {
    return draw(frame, camera, size, options);
  }
};

}  // namespace pointreel
