#include "tests/golden/picture_cases.h"

#include <array>
#include <cmath>
#include <utility>

#include "codec/core/build.h"
#include "pointreel/octree.h"

namespace pointreel::golden {
namespace {

constexpr int kBallPoints = 220, kSheetEdge = 10;
constexpr int kDepth = 4;

constexpr std::array<glm::u16vec3, 7> kPalette = {{{0xf000, 0x2000, 0x2000},
                                                   {0x2000, 0xc000, 0x3000},
                                                   {0x3000, 0x4000, 0xf000},
                                                   {0xf000, 0xd000, 0x2000},
                                                   {0xc000, 0x3000, 0xd000},
                                                   {0x2000, 0xc000, 0xd000},
                                                   {0xf000, 0x9000, 0x5000}}};

void add(PointCloud& cloud, const glm::vec3& p, const glm::vec3& n, float radius) {
  const std::size_t i = cloud.size();
  cloud.positions.push_back(p);
  cloud.normals.push_back(i % 29 == 11 ? glm::vec3(0.0f) : n);
  // The indices of neighbours on the spiral differ by 1, 8, 13 or 21. Only 21 is a multiple of 7.
  cloud.colors.push_back(kPalette[(i + i / 21) % kPalette.size()]);
  cloud.radii.push_back(radius);
}

std::shared_ptr<SceneFrame> frame_of(PointCloud cloud) {
  auto frame = std::make_shared<SceneFrame>();
  frame->cloud = std::move(cloud);
  const SortedPoints sorted = sort_points(frame->cloud, {glm::dvec3(-1.6), 3.2});
  frame->svo = build_svo(sorted, kDepth);
  frame->attributes = mean_attributes(frame->svo, frame->cloud, sorted);
  return frame;
}

Camera camera_from(double distance) {
  Camera camera;
  camera.distance = distance;
  camera.yaw = 0.4;
  camera.pitch = 0.3;
  return camera;
}

}  // namespace

PointCloud picture_cloud() {
  PointCloud cloud;
  // A Fibonacci spiral is even and has no symmetry that would hide a swapped axis.
  for (int i = 0; i < kBallPoints; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / kBallPoints;
    const double r = std::sqrt(1.0 - z * z), turn = 2.399963229728653 * i;
    const glm::vec3 n(r * std::cos(turn), z, r * std::sin(turn));
    add(cloud, 0.8f * n, n, 0.09f + 0.02f * static_cast<float>(i % 3));
  }
  const glm::vec3 across = glm::normalize(glm::vec3(1.0f, 0.3f, 0.2f));
  const glm::vec3 along = glm::normalize(glm::vec3(-0.2f, -0.2f, 1.3f));
  const glm::vec3 up = glm::normalize(glm::cross(along, across));
  for (int i = 0; i < kSheetEdge * kSheetEdge; ++i) {
    const float x = static_cast<float>(i % kSheetEdge) - 4.0f;
    const float y = static_cast<float>(i / kSheetEdge) - 4.5f;
    add(cloud, 0.26f * (x * across + y * along), up, 0.15f);
  }
  return cloud;
}

std::size_t middle_surfel() {
  const PointCloud cloud = picture_cloud();
  const glm::vec3 towards_eye(camera_from(4.0).axes()[2]);
  std::size_t best = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    // On the ball where it is above the sheet.
    if (i < kBallPoints && cloud.normals[i] != glm::vec3(0.0f) &&
        glm::dot(cloud.positions[i], towards_eye) > glm::dot(cloud.positions[best], towards_eye))
      best = i;
  }
  return best;
}

std::vector<PictureCase> picture_cases(const PointCloud& cloud) {
  const std::shared_ptr<const SceneFrame> frame = frame_of(cloud);
  const Camera camera = camera_from(4.0);
  std::vector<PictureCase> cases;
  const auto keep = [&](std::string name, const DrawOptions& options) {
    cases.push_back({std::move(name), frame, camera, options});
  };

  DrawOptions surfel;
  for (int i = 0; i <= static_cast<int>(Splatting::normalized); ++i) {
    surfel.splatting = static_cast<Splatting>(i);
    surfel.instancing = Instancing::attribute;
    keep(std::string("surfel-") + name(surfel.splatting), surfel);
  }
  DrawOptions pulled;
  keep("surfel-pulled", pulled);
  DrawOptions plain;
  plain.lighting = false;
  keep("surfel-unlit", plain);

  DrawOptions left = pulled;
  left.fill_holes = false;
  keep("surfel-holes-left", left);
  DrawOptions dome = pulled;
  dome.edl = 1.0f;
  keep("surfel-eye-dome", dome);

  DrawOptions voxel;
  voxel.mode = DrawMode::voxel;
  keep("voxel-faces", voxel);
  voxel.voxel_shape = VoxelShape::cube;
  voxel.instancing = Instancing::attribute;
  keep("voxel-cubes", voxel);
  voxel.pixel_size = 20.0f;
  keep("voxel-coarse", voxel);

  DrawOptions point;
  point.mode = DrawMode::point;
  point.point_size = 5.0f;
  point.adaptive_points = false;
  keep("point", point);

  // From inside the ball, with surfels behind the eye and across the near plane.
  keep("surfel-inside", pulled);
  cases.back().camera = camera_from(0.5);

  auto estimated = frame_of(cloud);
  estimated->normals_estimated = true;
  keep("surfel-either-side", pulled);
  cases.back().frame = estimated;

  PointCloud colorless = cloud;
  colorless.colors.clear();
  DrawOptions by_normals = pulled;
  by_normals.color = ColorSource::normals;
  keep("surfel-without-colors", by_normals);
  cases.back().frame = frame_of(std::move(colorless));

  PointCloud bare = cloud;
  bare.normals.clear();
  keep("surfel-without-normals", pulled);
  cases.back().frame = frame_of(std::move(bare));
  return cases;
}

}  // namespace pointreel::golden
