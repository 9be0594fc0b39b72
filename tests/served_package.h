#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

#include "codec/package/manifest.h"
#include "pointreel/package.h"
#include "tests/temporary_folder.h"

inline void write_file(const std::filesystem::path& path, const std::string& content) {
  std::ofstream(path, std::ios::binary) << content;
}

/// Bytes with a period that is coprime to every buffer size, so that misplaced bytes are noticed.
inline std::string patterned(std::size_t size) {
  std::string text(size, '\0');
  for (std::size_t i = 0; i < size; ++i) text[i] = static_cast<char>(i % 251);
  return text;
}

inline std::uint64_t checksum_of_text(const std::string& text) {
  return pointreel::checksum_of({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

/// The manifest of a reel with one frame of two layers with the given contents.
inline pointreel::Manifest small_manifest(const std::string& base, const std::string& full) {
  using namespace pointreel;
  Manifest manifest;
  manifest.name = "test";
  manifest.codec = "octree";
  manifest.entropy = "none";
  manifest.fps = 25;
  manifest.duration_us = 40000;
  manifest.layer_names = {"base", "full"};
  manifest.bounds.grow(glm::dvec3(0));
  manifest.bounds.grow(glm::dvec3(1));
  Segment segment;
  segment.times_us = {0};
  segment.points = {7};
  segment.cube = {{0, 0, 0}, 1};
  for (const auto& [path, content] : {std::pair{"0.base.prs", base}, {"0.full.prs", full}}) {
    segment.layers.push_back({{path, content.size(), checksum_of_text(content)},
                              {{static_cast<std::uint32_t>(content.size()), 0, 0}}});
  }
  manifest.segments = {segment};
  return manifest;
}

/// Writes such a package. The contents are not real frames: the server never reads them.
inline void write_package(const std::filesystem::path& folder, const std::string& base,
                          const std::string& full) {
  std::filesystem::create_directories(folder);
  write_file(folder / "reel.json", write_manifest(small_manifest(base, full)));
  write_file(folder / "0.base.prs", base);
  write_file(folder / "0.full.prs", full);
}
