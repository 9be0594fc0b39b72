#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "codec/files/ply.h"
#include "pointreel/draco.h"
#include "server/pack/packer.h"
#include "tests/served_package.h"

namespace pointreel {

/// A coloured ball with no two points at the same place, turned a little further in each frame.
inline PointCloud ball(std::size_t points, int frame) {
  PointCloud cloud;
  for (std::size_t i = 0; i < points; ++i) {
    const double z = 1.0 - 2.0 * (static_cast<double>(i) + 0.5) / static_cast<double>(points);
    const double angle = 2.399963 * static_cast<double>(i) + 0.1 * frame;
    const double r = std::sqrt(1.0 - z * z);
    const glm::vec3 p(r * std::cos(angle), r * std::sin(angle), z);
    cloud.positions.push_back(p);
    cloud.normals.push_back(p);
    cloud.colors.push_back(glm::u16vec3(257 * (i % 256), 257 * 9, 257 * 200));
  }
  return cloud;
}

inline std::string read_text(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Names and contents of all files in a folder.
inline std::map<std::string, std::string> contents(const std::filesystem::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    files[entry.path().filename().string()] =
        entry.is_directory() ? "folder" : read_text(entry.path());
  }
  return files;
}

/// Input and output folders for one test. `frames` holds frame1.ply, frame2.ply, ... with 200
/// points and one more in each further frame.
class PackTest : public testing::Test {
 protected:
  PackTest() { std::filesystem::create_directory(frames_); }

  void write_frames(int count) {
    for (int i = 1; i <= count; ++i) {
      const auto path = frames_ / ("frame" + std::to_string(i) + ".ply");
      ASSERT_TRUE(write_ply(path, ball(200 + static_cast<std::size_t>(i), i)));
    }
  }

  PackOptions options() const {
    PackOptions options;
    options.inputs = {frames_};
    options.output = reel_;
    options.encode.codec = OctreeOptions{};
    options.segment_frames = 3;
    options.threads = 2;
    return options;
  }

  PackOptions draco_options() const {
    PackOptions draco = options();
    draco.encode.codec = DracoOptions{};
    return draco;
  }

  /// Options for frames with three layers.
  PackOptions layered_options() const {
    PackOptions layered = options();
    OctreeOptions octree;
    octree.depth = DepthRule::fixed(10);
    layered.encode.codec = octree;
    return layered;
  }

  /// The entries beside the inputs: a reel or nothing, but never anything unfinished.
  std::vector<std::string> outputs() const {
    std::vector<std::string> names;
    for (const auto& [name, content] : contents(folder_.path())) {
      if (name != "frames") names.push_back(name);
    }
    return names;
  }

  TemporaryFolder folder_;
  const std::filesystem::path frames_ = folder_.path() / "frames";
  const std::filesystem::path reel_ = folder_.path() / "ball.reel";
};

}  // namespace pointreel
