#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "client/source/source.h"
#include "pointreel/bytes.h"
#include "pointreel/package.h"

namespace pointreel {

/// Two frames with two layers. Every byte of a layer's file is its own offset, so that tests can
/// tell where bytes came from.
inline Manifest small_manifest() {
  Manifest manifest;
  manifest.name = "small";
  manifest.codec = "octree";
  manifest.entropy = "none";
  manifest.fps = 10.0;
  manifest.duration_us = 200'000;
  manifest.colors = manifest.normals = true;
  manifest.depth_min = manifest.depth_max = 3;
  manifest.bounds.grow(glm::dvec3(0.0));
  manifest.bounds.grow(glm::dvec3(1.0));
  manifest.layer_names = {"base", "full"};
  Segment segment;
  segment.times_us = {0, 100'000};
  segment.points = {5, 6};
  segment.layers = {{{"0.base.bin", 30, 1}, {{4, 3, 2}, {10, 6, 5}}},
                    {{"0.full.bin", 8, 2}, {{5, 0, 0}, {1, 1, 1}}}};
  manifest.segments = {segment};
  return manifest;
}

inline Bytes offsets(std::size_t from, std::size_t size) {
  Bytes bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::uint8_t>(from + i);
  return bytes;
}

inline std::string text_of(ByteView bytes) { return {bytes.begin(), bytes.end()}; }

/// Options that retry at once after a failure and never take slowness for a failure.
inline SourceOptions patient() {
  SourceOptions options;
  options.connect_timeout = options.stall_timeout = std::chrono::minutes(10);
  options.first_backoff = std::chrono::milliseconds(1);
  options.open_attempts = 3;
  return options;
}

}  // namespace pointreel
