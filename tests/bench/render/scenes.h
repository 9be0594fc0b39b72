#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "client/scene/frame.h"
#include "datasets_synthetic/motion.h"
#include "tests/bench/render/truth.h"

namespace pointreel::bench {

/// A pose of a sequence to draw pictures of.
struct SceneChoice {
  std::string name;
  const Motion* motion;
  int pose;
  std::size_t even_points;  ///< 0: as the scanner sees it
  bool colors = true;       ///< else drawn in those made from the normals, as the paper's clouds
};

/// The paper's five sequences as its scanner would give them, `poses` of each, and last the dense
/// one, without noise and evenly spread: with colours, whose edges are sharper than points can
/// tell, and without.
std::vector<SceneChoice> scene_choices(int poses, std::size_t even_points);

/// The same points, ready to draw in every mode, and what they were sampled from.
struct RenderScene {
  SceneChoice choice;
  TruthScene truth;
  double area = 0.0;     ///< of the surface, square metres
  double spacing = 0.0;  ///< sqrt(area / points), metres
  /// As the player prepares them of files (client/playback/prepare.h) without radii.
  std::shared_ptr<const SceneFrame> surfels, voxels;
};

/// The radius of the dense cloud's splats, in spacings.
inline constexpr double kDenseRadius = 0.7;

Result<RenderScene> make_render_scene(const SceneChoice& choice);

/// Prepared as a player with this mode and delta does.
Result<std::shared_ptr<const SceneFrame>> prepare_cloud(const PointCloud& cloud, DrawMode mode,
                                                        double delta);

/// The same points in another order.
std::shared_ptr<const SceneFrame> shuffled(const SceneFrame& frame, std::uint64_t seed);

/// The same points, white where the eye sees the surface they are of, black where another part of
/// it is in the way (`tolerance` metres or more).
std::shared_ptr<const SceneFrame> labelled(const SceneFrame& frame, const TruthScene& truth,
                                           const Camera& camera, double tolerance);

/// Points of the surface, about `points` of them, no two of which are nearer to each other than
/// 0.75 of sqrt(area / points) and hardly any place further from all of them than that: random
/// points one after another, each left out that is too near to one before (R. Cook, "Stochastic
/// Sampling in Computer Graphics", 1986). With normals and colours.
Result<PointCloud> even_cloud(const Body& body, double area, std::size_t points);

/// From the rays of a lattice: each hit stands for the square of the spacing, of which a slanted
/// surface has more; the three directions' squared cosines add up to one.
Result<double> surface_area(const SurfaceGrid& grid);

}  // namespace pointreel::bench
