#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "client/scene/camera.h"
#include "client/scene/cut.h"
#include "codec/core/build.h"
#include "datasets_synthetic/random.h"
#include "pointreel/octree.h"
#include "tests/stability/check.h"
#include "tests/stability/clouds.h"
#include "tests/stability/surfel_frames.h"

namespace pointreel::stability {
namespace {

constexpr glm::ivec2 kSize(640, 480);

/// How far (u, v, n) is from an orthonormal, right-handed frame.
double frame_error(const SurfelFrame& frame, const glm::vec3& n) {
  const glm::dvec3 u(frame.u), v(frame.v), w(n);
  const glm::dvec3 off = glm::abs(glm::cross(u, v) - w);
  const double error = std::max({std::abs(glm::dot(u, u) - 1.0), std::abs(glm::dot(v, v) - 1.0),
                                 std::abs(glm::dot(u, v)), std::abs(glm::dot(u, w)),
                                 std::abs(glm::dot(v, w)), off.x, off.y, off.z});
  return std::isfinite(error) ? error : HUGE_VAL;
}

/// Adds a check of the frames that the shaders compute for these normals.
void check_frames(Checks& checks, const std::string& where, const std::vector<glm::vec3>& normals) {
  Check check{"surfel frame", "poles", "orthonormal to 1e-6, right-handed", "", false};
  if (const auto frames = surfel_frames(normals)) {
    double error = 0.0;
    for (std::size_t i = 0; i < normals.size(); ++i)
      error = std::max(error, frame_error((*frames)[i], normals[i]));
    check.outcome = fmt::format("{}: off by {:.1e}", where, error);
    check.passed = error <= 1e-6;
  } else {
    check.outcome = where + ": " + frames.error().message;
  }
  checks.push_back(check);
}

void check_frames(Checks& checks) {
  constexpr float kUlp = std::numeric_limits<float>::denorm_min();
  const float below_one = std::nextafter(1.0f, 0.0f);
  std::vector<glm::vec3> poles, beside, anywhere;
  for (const float sign : {1.0f, -1.0f}) {
    poles.emplace_back(0, sign, 0);
    for (const float tilt : {kUlp, 1e-30f, 1e-10f, 0.999e-6f, 1.001e-6f, 1e-4f}) {
      for (const glm::vec3& side : {glm::vec3(tilt, 0, 0), glm::vec3(0, 0, -tilt)}) {
        beside.push_back(glm::vec3(0, sign, 0) + side);
        beside.push_back(glm::vec3(0, sign * below_one, 0) + side);
      }
    }
  }
  Random random(1, 0);
  for (int i = 0; i < 20000; ++i) {
    const glm::dvec3 n(random.normal(), random.normal(), random.normal());
    anywhere.emplace_back(n / std::sqrt(glm::dot(n, n)));
  }
  check_frames(checks, "n = (0, +-1, 0)", poles);
  check_frames(checks, "one ulp to 1e-4 beside", beside);
  check_frames(checks, "20,000 directions", anywhere);
}

/// Near the eye, the cut descends to nodes that would be too small to see from anywhere else.
void check_cut(Checks& checks) {
  const PointCloud ball = ball_cloud(5000);
  const Svo svo = build_svo(sort_points(ball, bounding_cube(bounds(ball))), 8);
  VoxelCut cut;
  const auto finite = [&cut] {
    return std::all_of(cut.nodes().begin(), cut.nodes().end(), [](const CutNode& node) {
      return std::isfinite(node.center.x) && std::isfinite(node.center.y) &&
             std::isfinite(node.center.z) && std::isfinite(node.half) && node.half > 0.0f;
    });
  };
  // Whether all emitted nodes that contain the eye, or come within `reach` of it, are leaves.
  const auto leaves_only = [&](const Camera& camera, double reach) {
    const glm::dvec3 eye = camera.eye() - svo.cube.origin;
    return std::all_of(cut.nodes().begin(), cut.nodes().end(), [&](const CutNode& node) {
      const glm::dvec3 off = glm::abs(glm::dvec3(node.center) - eye);
      const bool near = std::max({off.x, off.y, off.z}) <= static_cast<double>(node.half) + reach;
      return !near || node.node >= svo.internal_count();
    });
  };
  Camera camera;
  camera.frame_bounds(bounds(ball), 4.0 / 3.0);
  // So coarse that only the root would be drawn if the eye were not inside it.
  constexpr float kCoarse = 1e4f;
  for (const double height : {0.0, 0.25, 0.4995}) {
    camera.target = {0.0, height, 0.0};
    camera.distance = 1e-3;
    const CutStats stats = cut.run(svo, camera, kSize, kCoarse);
    checks.push_back({"level of detail", "eye inside a node", "descends to the leaves; no NaN",
                      fmt::format("eye {:g} above the centre: {} of {} nodes visited, {} emitted",
                                  height, stats.visited, svo.node_count(), stats.emitted),
                      finite() && leaves_only(camera, 0.0) && stats.visited > 1});
  }
  camera.target = glm::dvec3(0.0);
  camera.distance = 0.5;  // on the surface
  cut.run(svo, camera, kSize, kCoarse);
  checks.push_back({"level of detail", "at the near plane", "descends where z <= near; no NaN",
                    fmt::format("eye on the surface: {} emitted", cut.nodes().size()),
                    finite() && leaves_only(camera, camera.near_plane())});
  camera.target = {0.0, 0.0, 10.0};
  camera.yaw = 0.0;
  camera.pitch = 0.0;
  camera.distance = 3.0;
  const CutStats ahead = cut.run(svo, camera, kSize, 1.0f);
  camera.yaw = 3.141592653589793;
  const CutStats behind = cut.run(svo, camera, kSize, 1.0f);
  checks.push_back({"level of detail", "behind the eye", "culled at the root",
                    fmt::format("ahead {} emitted, behind {} visited, {} emitted", ahead.emitted,
                                behind.visited, behind.emitted),
                    ahead.emitted > 0 && behind.emitted == 0 && behind.visited == 1});
}

void check_depth(Checks& checks) {
  Camera camera;
  const glm::mat4 projection = camera.projection(4.0 / 3.0);
  const auto depth = [&projection](double z) {
    const glm::vec4 clip = projection * glm::vec4(0.0f, 0.0f, static_cast<float>(-z), 1.0f);
    return clip.z / clip.w;
  };
  double worst = 0.0;
  for (double z = camera.near_plane(); z <= 1e5 * camera.near_plane(); z *= 1.7) {
    double apart = 0x1p-24;
    while (apart < 1.0 && !(depth(z * (1.0 + apart)) < depth(z))) apart *= 2.0;
    worst = std::max(worst, apart);
  }
  checks.push_back(
      {"depth", "far over near of 1e5", "tells apart 1e-6 of the distance everywhere",
       fmt::format("{:.1e} of the distance, from the near plane to 1e5 times it", worst),
       worst <= 1e-6});
}

}  // namespace

Checks drawing_checks() {
  Checks checks;
  check_frames(checks);
  check_cut(checks);
  check_depth(checks);
  return checks;
}

}  // namespace pointreel::stability
