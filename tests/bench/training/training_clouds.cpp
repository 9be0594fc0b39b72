#include "tests/bench/training/training_clouds.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "codec/core/build.h"
#include "codec/surface/clean.h"
#include "common/base/try.h"
#include "datasets_synthetic/motion.h"
#include "datasets_synthetic/random.h"
#include "datasets_synthetic/sequences.h"
#include "pointreel/octree.h"
#include "tests/bench/training/figures.h"
#include "tests/bench/training/relief.h"
#include "tests/bench/training/sampled_surface.h"
#include "tests/bench/training/sensors.h"
#include "tests/bench/training/terrain.h"
#include "tests/bench/training/things.h"

namespace pointreel::bench {
namespace {

/// The points of a cloud whose normals are not needed.
SampledSurface surface_of(const PointCloud& cloud) {
  SampledSurface surface;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    surface.push_back({cloud.world(i) / 1.76, {0, 0, 1}});
  }
  return surface;
}

/// A random frame of a synthetic sequence from one of its own samplers.
Result<SampledSurface> sequence_sample(const Motion& motion, const SequenceOptions& options,
                                       Random& random) {
  const int frames = static_cast<int>(motion.seconds() * options.fps);
  return surface_of(TRY(sequence_frame(
      motion, options, static_cast<int>(random.below(static_cast<std::uint32_t>(frames))))));
}

/// The tree of the occupied cells of a grid with 2^bits cells along the largest extent of the
/// surface. A `margin` above 0 leaves that share of the grid empty.
Svo tree_of(const SampledSurface& surface, int bits, double margin = 0.0) {
  glm::dvec3 low(1e30), high(-1e30);
  for (const Sample& sample : surface) {
    low = glm::min(low, sample.position);
    high = glm::max(high, sample.position);
  }
  const glm::dvec3 extent = high - low;
  const double edge = std::max({extent.x, extent.y, extent.z, 1e-9});
  const double cells = std::ldexp(1.0, bits), scale = (cells - 1.0) * (1.0 - margin) / edge;
  PointCloud cloud;
  cloud.positions.reserve(surface.size());
  for (const Sample& sample : surface) {
    cloud.positions.emplace_back(glm::floor((sample.position - low) * scale + 0.5) + 0.5);
  }
  return build_svo(sort_points(cloud, Cube{glm::dvec3(0.0), cells}, bits), bits);
}

constexpr std::size_t kSamples = 1'200'000;

/// Makes the trees of surfaces and passes them on to the training.
class Giver {
 public:
  using Use = std::function<void(const std::string& name, const Svo& svo)>;
  explicit Giver(const Use& use) : use_(use) {}

  void operator()(const std::string& name, const Svo& svo) const { use_(name, svo); }

  /// Passes on tree_of(surface, bits, margin).
  void operator()(const std::string& name, const SampledSurface& surface, int bits,
                  double margin = 0.0) const {
    use_(name, tree_of(surface, bits, margin));
  }

 private:
  const Use& use_;
};

/// Figures that are sampled densely, at random, with the spacing of vertices, and by cameras.
Result<void> give_figures(std::uint64_t seed, const Giver& give) {
  constexpr int kFigures = 6;
  for (int f = 0; f < kFigures; ++f) {
    Random random(seed, static_cast<std::uint64_t>(f));
    const SampledSurface smooth = TRY(figure(kSamples, random));
    const auto name = [f](const char* what) { return fmt::format("figure {} {}", f, what); };
    const double roughness = 0.2 + 1.2 * random.uniform();
    const SampledSurface rough =
        displaced(smooth, Relief::fractal(0.12, 0.001, 0.006 * roughness, 1.0, 0.4, random));
    const SampledSurface fine =
        displaced(rough, Relief::fractal(0.01, 0.0005, 0.0012 * roughness, 0.5, 0.0, random));

    const SampledSurface& dense = f % 2 == 0 ? rough : fine;
    give(name("dense 10"), filled(dense, 0.4 / 1024), 10, 0.05 * random.uniform());
    if (f % 3 == 0) give(name("dense 9"), dense, 9, 0.3 * random.uniform());
    if (f % 2 == 1) give(name("smooth 10"), filled(smooth, 0.4 / 1024), 10, 0.02 * f);
    if (f % 2 == 0) give(name("dense 10 again"), filled(fine, 0.4 / 1024), 10, 0.01 * f);

    give(name("random 90,000 10"), first(f % 2 == 0 ? smooth : rough, 90'000), 10,
         0.1 * random.uniform());
    if (f % 3 == 1) give(name("random 250,000 12"), first(rough, 250'000), 12);
    if (f % 3 == 2) give(name("random 60,000 9"), first(rough, 60'000), 9);

    const SampledSurface vertices = spaced(fine, 0.0014 + 0.0002 * f, 0.15 + 0.05 * f, random);
    give(name("spaced 10"), vertices, 10);
    give(name("spaced 12"), vertices, 12);
    if (f % 2 == 0) give(name("spaced 11"), spaced(rough, 0.004, 0.3, random), 11);

    SampledSurface seen = scanned(rough, 5, (1.8 + 3.0 * random.uniform()) / 1024, random);
    disturb(seen, (0.3 + random.uniform()) / 1024, 0.004, random);
    give(name("scanned 10"), seen, 10);
    if (f % 3 == 0) {
      SampledSurface noisy = first(rough, 400'000);
      disturb(noisy, (0.4 + random.uniform()) / 1024, 0.001, random);
      give(name("noisy 10"), noisy, 10);
    }
  }
  return {};
}

/// Figures with few faces, sampled at random.
void give_faceted(std::uint64_t seed, const Giver& give) {
  for (int f = 0; f < 4; ++f) {
    Random random(seed, 3000 + static_cast<std::uint64_t>(f));
    give(fmt::format("faceted {} 10", f),
         faceted_figure(60'000 + 15'000 * static_cast<std::size_t>(f), random), 10,
         0.1 * random.uniform());
  }
}

/// Figures as several badly calibrated cameras see them, noisy and sparse.
Result<void> give_captures(std::uint64_t seed, const Giver& give) {
  for (int f = 0; f < 4; ++f) {
    Random random(seed, 4000 + static_cast<std::uint64_t>(f));
    const SampledSurface smooth = TRY(figure(kSamples, random));
    const SampledSurface rough =
        displaced(smooth, Relief::fractal(0.1, 0.001, 0.004, 1.0, 0.4, random));
    const double voxel = 1.0 / 1024;
    CameraErrors errors;
    errors.shift = voxel * (0.5 + random.uniform());
    errors.bend = voxel * 2.0 * random.uniform();
    errors.step = f % 2 == 0 ? 0.0 : voxel * (0.5 + 1.5 * random.uniform());
    errors.flying = 0.1 + 0.3 * random.uniform();
    SampledSurface seen =
        scanned(rough, 4 + 2 * f, voxel * (2.0 + 0.8 * f + random.uniform()), random, errors);
    disturb(seen, voxel * (0.3 + 0.9 * random.uniform()), 0.003, random);
    give(fmt::format("captured {} 10", f), seen, 10);
  }
  return {};
}

/// The voxels that the figures of the synthetic sequences pass through. The kick is left out, so
/// that it can be measured.
Result<void> give_voxels(const Giver& give) {
  for (const char* name : {"baseball", "basketball", "soccer-juggle", "soccer-shoot"}) {
    const Motion& motion = *find_motion(name);
    SequenceOptions options;
    for (const int bits : {8, 9, 10}) {
      options.voxels = voxel_grid(sequence_bounds(motion, options.fps, motion.poses), bits);
      const int pose = motion.poses * (2 * bits - 15) / 6;
      const PointCloud cloud = TRY(sequence_frame(motion, options, pose));
      const VoxelCube cube = voxel_cube(bounds(cloud), 1.0);
      give(fmt::format("voxels {} {}", name, bits),
           build_svo(sort_points(cloud, cube.cube, cube.depth), cube.depth));
    }
  }
  return {};
}

/// The synthetic sequences with their own samplers: the curves of a scanner, and parallel rays.
Result<void> give_sequences(std::uint64_t seed, const Giver& give) {
  for (int m = 0; m < 6; ++m) {
    Random random(seed, 5000 + static_cast<std::uint64_t>(m));
    const std::span<const Motion> all = motions();
    const Motion& motion = all[static_cast<std::size_t>(m) % all.size()];
    SequenceOptions options;
    options.seed = random.bits();
    options.noise = m < 3 ? 0.0015 * m : 0.0;
    if (m >= 3) options.points = 30'000u << (m - 3);
    const auto curves = TRY(sequence_sample(motion, options, random));
    give(fmt::format("curves {} {}", m, m < 5 ? 10 : 11), curves, m < 5 ? 10 : 11,
         0.1 * random.uniform());
    if (m >= 2) continue;
    options.noise = 0.0;
    options.sampler = Sampler::ldc;
    const auto layered = TRY(sequence_sample(motion, options, random));
    give(fmt::format("layered {} 10", m), layered, 10, 0.1 * random.uniform());
  }
  return {};
}

/// What the sequences' ring of depth cameras measures, as it comes and cleaned, in the cells that
/// each of them would be coded in, and in larger ones.
Result<void> give_depth_cameras(std::uint64_t seed, const Giver& give) {
  constexpr std::array<std::size_t, 5> kPoints = {12'000, 25'000, 50'000, 90'000, 150'000};
  for (std::size_t c = 0; c < kPoints.size(); ++c) {
    Random random(seed, 7000 + c);
    const std::span<const Motion> all = motions();
    const Motion& motion = all[(c + 2) % all.size()];
    SequenceOptions options;
    options.seed = random.bits();
    options.sampler = Sampler::depth_cameras;
    options.points = kPoints[c];
    const int frames = static_cast<int>(motion.seconds() * options.fps);
    PointCloud cloud = TRY(sequence_frame(
        motion, options, static_cast<int>(random.below(static_cast<std::uint32_t>(frames)))));
    for (const bool cleaned : {false, true}) {
      if (cleaned) clean(cloud);
      const SampledSurface surface = surface_of(cloud);
      const int bits = c == 0 ? 8 : c < 3 ? 9 : 10;
      for (const int more : {0, 1}) {
        give(fmt::format("depth cameras {} {}{}", c, bits + more, cleaned ? " cleaned" : ""),
             surface, bits + more, 0.1 * random.uniform());
      }
    }
  }
  return {};
}

/// Towns and hills as an airborne scanner sees them.
void give_terrain(std::uint64_t seed, const Giver& give) {
  for (int t = 0; t < 2; ++t) {
    Random random(seed, 6000 + static_cast<std::uint64_t>(t));
    const SampledSurface ground = terrain(450'000, random);
    const double line = 0.0006 + 0.0012 * random.uniform();
    const SampledSurface flown =
        built_up(flown_over(ground, line, 0.2 + 0.4 * random.uniform(), random), random);
    give(fmt::format("town {} 12", t), flown, 12);
  }
  for (int t = 0; t < 3; ++t) {
    Random random(seed, 1000 + static_cast<std::uint64_t>(t));
    const SampledSurface ground = terrain(400'000, random);
    const SampledSurface flown =
        flown_over(ground, 0.0008 + 0.0015 * random.uniform(), 0.3, random);
    give(fmt::format("terrain {} 12", t), flown, 12);
    if (t == 0) give(fmt::format("terrain {} 10", t), ground, 10);
  }
}

/// Furniture and animals, sampled densely, at random, with the spacing of vertices, and by cameras.
void give_things(std::uint64_t seed, const Giver& give) {
  for (int t = 0; t < 6; ++t) {
    Random random(seed, 8000 + static_cast<std::uint64_t>(t));
    const bool alive = t % 2 == 1;
    const SampledSurface smooth =
        sample_thing(alive ? animal(random) : furniture(random), kSamples, random);
    const double roughness = alive ? 0.3 + random.uniform() : 0.1 * random.uniform();
    const SampledSurface rough =
        displaced(smooth, Relief::fractal(0.08, 0.0008, 0.005 * roughness, 0.8, 0.2, random));
    const auto name = [&](const char* what) {
      return fmt::format("{} {} {}", alive ? "animal" : "furniture", t, what);
    };
    if (t < 4) give(name("dense 10"), filled(rough, 0.4 / 1024), 10, 0.1 * random.uniform());
    give(name("random 10"), first(rough, 30'000u << (t / 2)), 10, 0.1 * random.uniform());
    give(name("spaced 10"), spaced(rough, 0.002 + 0.001 * t, 0.3, random), 10);
    SampledSurface seen = scanned(rough, 5, (1.8 + 3.0 * random.uniform()) / 1024, random);
    disturb(seen, (0.2 + random.uniform()) / 1024, 0.003, random);
    give(name("scanned 10"), seen, 10);
    if (t < 2) give(name("scanned 12"), seen, 12);
  }
}

/// Points that fill a volume.
void give_volume(std::uint64_t seed, const Giver& give) {
  Random random(seed, 2000);
  SampledSurface cloudy(40'000);
  for (Sample& sample : cloudy) {
    const double x = random.uniform(), y = random.uniform(), z = random.uniform();
    sample = {{x, y, z}, {0, 0, 1}};
  }
  give("volume 8", cloudy, 8);
}

}  // namespace

Result<void> for_each_training_tree(
    std::uint64_t seed, const std::function<void(const std::string& name, const Svo& svo)>& use) {
  const Giver give(use);
  TRY(give_figures(seed, give));
  give_faceted(seed, give);
  TRY(give_captures(seed, give));
  TRY(give_sequences(seed, give));
  TRY(give_voxels(give));
  TRY(give_depth_cameras(seed, give));
  give_terrain(seed, give);
  give_things(seed, give);
  give_volume(seed, give);
  return {};
}

}  // namespace pointreel::bench
