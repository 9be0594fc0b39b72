#include <algorithm>
#include <array>
#include <bit>
#include <tuple>

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "codec/distance/distance.h"
#include "codec/surface/normals.h"
#include "datasets_synthetic/motion.h"
#include "datasets_synthetic/sequences.h"
#include "pointreel/chunks.h"
#include "pointreel/codec.h"
#include "pointreel/draco.h"
#include "pointreel/package.h"
#include "tests/stability/check.h"
#include "tests/stability/clouds.h"

namespace pointreel::stability {
namespace {

template <class Work>
auto on_threads(int threads, const Work& work) {
  tbb::task_arena arena(threads);
  return arena.execute(work);
}

/// The hash of all bytes of a frame.
std::uint64_t hash_of(const Result<EncodedFrame>& frame) {
  Bytes all;
  if (frame) {
    for (const Chunks<Bytes>& layer : frame->layers) {
      for (const Bytes* part : {&layer.geometry, &layer.colors, &layer.normals}) {
        all.insert(all.end(), part->begin(), part->end());
      }
    }
  }
  return checksum_of(all);
}

template <class T>
std::uint64_t hash_of(const std::vector<T>& values) {
  return checksum_of(
      {reinterpret_cast<const std::uint8_t*>(values.data()), values.size() * sizeof(T)});
}

void check_encoders(Checks& checks) {
  const PointCloud cloud = ball_cloud(8000), other = shuffled(cloud);
  const Cube cube = bounding_cube(bounds(cloud));
  for (const Setting& setting : settings(5)) {  // a coarse depth, so that cells hold several points
    const auto encode = [&](const PointCloud& source) {
      return hash_of(encode_frame(source, cube, setting.options));
    };
    const std::uint64_t one = encode(cloud), turned = encode(other);
    checks.push_back({"octree", "input order and threads", "same bytes for any order of the points",
                      fmt::format("{}: {:016x} and {:016x}", setting.name, one, turned),
                      one == turned});
    std::array<std::uint64_t, 4> hashes{};
    on_threads(2, [&] {
      tbb::parallel_for(std::size_t{0}, hashes.size(),
                        [&](std::size_t i) { hashes[i] = encode(i % 2 == 0 ? cloud : other); });
      return 0;
    });
    const auto same = std::count(hashes.begin(), hashes.end(), one);
    checks.push_back({"octree", "input order and threads", "same bytes when encoded in parallel",
                      fmt::format("{}: {} of {} equal", setting.name, same, hashes.size()),
                      same == static_cast<std::ptrdiff_t>(hashes.size())});
  }
}

void check_threads(Checks& checks) {
  const auto add = [&](const char* what, std::uint64_t one, std::uint64_t two) {
    checks.push_back({"determinism", what, "the same on 1 and 2 threads",
                      fmt::format("{:016x} and {:016x}", one, two), one == two});
  };
  const auto sequence = [] {
    SequenceOptions options;
    options.points = 3000;
    const Motion* walk = find_motion("walk");
    const auto frame = walk ? sequence_frame(*walk, options, 3)
                            : Result<PointCloud>(fail("there is no motion called walk"));
    return frame ? hash_of(frame->positions) : 0;
  };
  add("a generated frame", on_threads(1, sequence), on_threads(2, sequence));
  PointCloud a = ball_cloud(5000);
  const PointCloud b = ball_cloud(4000, {0.01, 0.0, 0.0});
  const auto distance = [&] {
    const auto d = cloud_distance(a, b);
    if (!d) return std::uint64_t{0};
    return hash_of(std::vector<double>{d->d1(), d->d2().value_or(-1.0), d->max(),
                                       d->colors().value_or(ColorError(-1.0)).x,
                                       d->normals().value_or(AngleError{}).mean});
  };
  add("error metrics", on_threads(1, distance), on_threads(2, distance));
  const auto normals = [&] {
    PointCloud cloud = a;
    estimate_normals_and_radii(cloud);
    return hash_of(cloud.normals) ^ hash_of(cloud.radii);
  };
  add("estimated normals", on_threads(1, normals), on_threads(2, normals));
}

void check_voxels(Checks& checks) {
  constexpr int kBits = 10;
  constexpr double kVoxel = 0.002;
  // The source is voxelised: a ball on a lattice with one point for each voxel.
  std::vector<std::tuple<int, int, int>> voxels;
  for (const glm::dvec3& p : positions_of(ball_cloud(20000))) {
    const glm::dvec3 cell = glm::floor((p + 0.5) * 1023.0 + 0.5);
    voxels.emplace_back(static_cast<int>(cell.x), static_cast<int>(cell.y),
                        static_cast<int>(cell.z));
  }
  std::sort(voxels.begin(), voxels.end());
  voxels.erase(std::unique(voxels.begin(), voxels.end()), voxels.end());
  PointCloud cloud;
  cloud.origin = {100.0, -3.0, 0.5};
  for (const auto& [x, y, z] : voxels) {
    cloud.positions.push_back(glm::vec3(kVoxel * glm::dvec3(x, y, z)));
    cloud.colors.push_back(glm::u16vec3(x % 256, y % 256, z % 256) * std::uint16_t{257});
  }
  const VoxelCube grid = voxel_cube(bounds(cloud), kVoxel);
  for (const Setting& setting : settings(grid.depth)) {
    const auto frame = encode_frame(cloud, grid.cube, setting.options);
    const auto decoded = frame ? decode_frame(layer_views(frame->layers))
                               : Result<DecodedFrame>(tl::unexpected(frame.error()));
    std::size_t exact = 0, colors = 0;
    if (decoded && decoded->cloud.size() == cloud.size()) {
      for (std::size_t i = 0; i < cloud.size(); ++i) {
        const glm::dvec3 at = (decoded->cloud.world(i) - cloud.origin) / kVoxel;
        const glm::dvec3 whole = glm::floor(at + 0.5);
        const std::tuple voxel(static_cast<int>(whole.x), static_cast<int>(whole.y),
                               static_cast<int>(whole.z));
        const auto found = std::lower_bound(voxels.begin(), voxels.end(), voxel);
        if (found == voxels.end() || *found != voxel) continue;
        const glm::dvec3 off = glm::abs(at - whole);
        exact += std::max({off.x, off.y, off.z}) < 1e-3;
        colors += decoded->cloud.has_colors() &&
                  decoded->cloud.colors[i] ==
                      cloud.colors[static_cast<std::size_t>(found - voxels.begin())];
      }
    }
    checks.push_back({"round trip", fmt::format("a source of {}-bit voxels", kBits),
                      "every voxel and its colour exactly",
                      fmt::format("{}: {} of {} voxels, {} colours, depth {}", setting.name, exact,
                                  cloud.size(), colors, grid.depth),
                      exact == cloud.size() && colors == cloud.size()});
  }
}

}  // namespace

Checks determinism_checks() {
  Checks checks;
  check_encoders(checks);
  check_threads(checks);
  check_voxels(checks);
  return checks;
}

}  // namespace pointreel::stability
