#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "codec/files/ply.h"
#include "pointreel/cloud.h"
#include "server/pack/packer.h"
#include "tests/packed_reel.h"

/// `n` points on an ellipsoid around `center` along a golden spiral, with colours and normals.
inline pointreel::PointCloud ellipsoid(std::size_t n, const glm::dvec3& center = {}) {
  pointreel::PointCloud cloud;
  for (std::size_t i = 0; i < n; ++i) {
    const double z = 1.0 - (2.0 * static_cast<double>(i) + 1.0) / static_cast<double>(n);
    const double r = std::sqrt(1.0 - z * z), angle = 2.399963229728653 * static_cast<double>(i);
    const glm::dvec3 normal(r * std::cos(angle), r * std::sin(angle), z);
    cloud.positions.emplace_back(center + normal * glm::dvec3(1.0, 0.75, 0.5));
    cloud.normals.emplace_back(normal);
    cloud.colors.emplace_back(257 * (i % 256), 257 * (i / 2 % 256), 257 * (i / 4 % 256));
  }
  return cloud;
}

/// Writes such frames of 100, 101, ... points, each moved a little, as FOLDER/frame_0.ply, ...
inline void write_frames(const std::filesystem::path& folder, std::size_t frames,
                         std::size_t points = 100) {
  std::filesystem::create_directories(folder);
  for (std::size_t i = 0; i < frames; ++i) {
    const auto written =
        write_ply(folder / fmt::format("frame_{}.ply", i),
                  ellipsoid(points + i, glm::dvec3(0.25 * static_cast<double>(i), 1.0, -2.0)));
    ASSERT_TRUE(written) << written.error().message;
  }
}

/// Options that pack a folder of files at depth 10, where the octree has all three layers.
inline pointreel::PackOptions pack_options(const std::filesystem::path& input,
                                           const std::filesystem::path& output) {
  pointreel::PackOptions options;
  options.inputs = {input};
  options.output = output;
  options.threads = 2;
  options.fps = 25.0;
  options.encode.codec =
      pointreel::OctreeOptions{pointreel::Entropy::zstd, pointreel::DepthRule::fixed(10)};
  return options;
}

/// The names of all entries of a folder, hidden ones included.
inline std::set<std::string> names_in(const std::filesystem::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    names.insert(entry.path().filename().string());
  }
  return names;
}

/// All points of a cloud in world coordinates, in arbitrary order.
inline std::multiset<std::vector<double>> world_points(const pointreel::PointCloud& cloud) {
  std::multiset<std::vector<double>> points;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::dvec3 p = cloud.world(i);
    points.insert({p.x, p.y, p.z});
  }
  return points;
}
