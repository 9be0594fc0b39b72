#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "client/scene/frame.h"
#include "datasets_synthetic/motion.h"
#include "tests/bench/render/truth.h"

namespace pointreel::bench {

/// A pose of a sequence of which pictures are drawn.
struct SceneChoice {
  std::string name;
  const Motion* motion;
  int pose;
  std::size_t even_points;  ///< points of an even cloud; 0: scanned
  bool colors = true;       ///< false: colours made from the normals, as in the paper
};

/// The five sequences of Slomp et al., Geometry Instancing, as scanned, with `poses` of each; then
/// two dense scenes, without noise and evenly spread: with colours, whose edges are sharper than
/// points can show, and without.
std::vector<SceneChoice> scene_choices(int poses, std::size_t even_points);

/// The points of a scene, ready to draw in every mode, and the surface that they were sampled from.
struct RenderScene {
  SceneChoice choice;
  TruthScene truth;
  double area = 0.0;     ///< of the surface, in square metres
  double spacing = 0.0;  ///< sqrt(area / points), metres
  /// As the player prepares them from files without radii (client/prepare/prepare.h).
  std::shared_ptr<const SceneFrame> surfels, voxels;
};

/// The radius of the splats of the dense cloud, in spacings.
inline constexpr double kDenseRadius = 0.7;

Result<RenderScene> make_render_scene(const SceneChoice& choice);

/// Prepares a cloud as the player does with this mode and delta.
Result<std::shared_ptr<const SceneFrame>> prepare_cloud(const PointCloud& cloud, DrawMode mode,
                                                        double delta);

/// The same frame with its points in another order.
std::shared_ptr<const SceneFrame> shuffled(const SceneFrame& frame, std::uint64_t seed);

/// The same frame with white points where they are visible, and black points where another part of
/// the surface hides them by `tolerance` metres or more.
std::shared_ptr<const SceneFrame> labelled(const SceneFrame& frame, const TruthScene& truth,
                                           const Camera& camera, double tolerance);

/// About `points` points on the surface, with normals and colours. No two of them are nearer to
/// each other than 0.75 sqrt(area / points), and hardly any place is further from all of them than
/// that. Made by drawing random points and leaving out each that is too near to an earlier one (R.
/// Cook, "Stochastic Sampling in Computer Graphics", 1986).
Result<PointCloud> even_cloud(const Body& body, double area, std::size_t points);

/// The area of the surface, from the rays of a lattice in three directions. Each hit stands for the
/// square of the spacing times the cosine of its angle, because slanted surfaces are hit less often
/// and the squared cosines of the three directions add up to one.
Result<double> surface_area(const SurfaceGrid& grid);

}  // namespace pointreel::bench
