#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>

#include "codec/files/cloud_file.h"
#include "codec/files/ply.h"
#include "codec/octree/frame_header.h"
#include "codec/package/manifest.h"
#include "pointreel/chunks.h"
#include "pointreel/codec.h"
#include "pointreel/draco.h"
#include "pointreel/package.h"
#include "tests/stability/check.h"
#include "tests/stability/clouds.h"

namespace pointreel::stability {
namespace {

constexpr std::size_t kStreamedPoints = 60;
constexpr int kDepth = 8;

void check_damage(const Setting& setting, Checks& checks) {
  const PointCloud cloud = ball_cloud(kStreamedPoints);
  const auto encoded = encode_frame(cloud, bounding_cube(bounds(cloud)), setting.options);
  if (!encoded || !decode_frame(layer_views(encoded->layers))) {
    checks.push_back({"stream", "truncated at every byte", "an error",
                      setting.name + ": the whole frame fails", false});
    return;
  }
  std::vector<Chunks<Bytes>> layers = encoded->layers;
  std::size_t cuts = 0, cut_refused = 0, flips = 0, flips_refused = 0;
  for (std::size_t layer = 0; layer < layers.size(); ++layer) {
    const auto cut = [&](auto part) {
      auto views = layer_views(layers);
      const ByteView whole = views[layer].*part;
      // An empty chunk counts as not fetched, which is allowed for all but the first geometry.
      const bool first = layer == 0 && part == &Chunks<ByteView>::geometry;
      for (std::size_t size = first ? 0 : 1; size < whole.size(); ++size) {
        views[layer].*part = whole.first(size);
        ++cuts;
        cut_refused += !decode_frame(views);
      }
    };
    const auto flip = [&](Bytes& bytes) {
      for (std::uint8_t& byte : bytes) {
        for (int bit = 0; bit < 8; ++bit) {
          byte = static_cast<std::uint8_t>(byte ^ 1 << bit);
          ++flips;
          flips_refused += !decode_frame(layer_views(layers));
          byte = static_cast<std::uint8_t>(byte ^ 1 << bit);
        }
      }
    };
    cut(&Chunks<ByteView>::geometry);
    cut(&Chunks<ByteView>::colors);
    cut(&Chunks<ByteView>::normals);
    flip(layers[layer].geometry);
    flip(layers[layer].colors);
    flip(layers[layer].normals);
  }
  const auto add = [&](const char* subject, std::size_t tried, std::size_t refused) {
    checks.push_back({"stream", subject, "an error",
                      fmt::format("{}: {} of {} refused", setting.name, refused, tried),
                      tried > 0 && refused == tried});
  };
  add("truncated at every byte", cuts, cut_refused);
  add("every bit flipped", flips, flips_refused);
}

/// Whether a frame decodes that has correct checksums and these headers and payload.
bool forged_decodes(const FrameHeader& header, const ChunkHeader& chunk, const Bytes& payload) {
  Bytes bytes;
  write_frame_header(header, 7, bytes);
  write_chunk(chunk, 7, payload, bytes);
  return decode_frame({Chunks<ByteView>{bytes, {}, {}}}).has_value();
}

void check_forged(Checks& checks) {
  const auto header = [](Codec codec, int depth, std::uint32_t points) {
    FrameHeader h;
    h.codec = codec;
    h.depth = static_cast<std::uint8_t>(depth);
    h.source_points = h.coded_points = points;
    return h;
  };
  const auto chunk = [](int last_level, std::uint32_t raw_size, Entropy entropy = Entropy::none) {
    return ChunkHeader{ChunkKind::geometry, entropy, 0, static_cast<std::uint8_t>(last_level),
                       raw_size};
  };
  constexpr std::uint32_t kMost = 0xffffffffu;
  const bool honest = forged_decodes(header(Codec::octree, 1, 2), chunk(1, 1), {0b11});
  const auto add = [&](const char* subject, const std::string& claim,
                       std::initializer_list<bool> decodes) {
    const auto taken = std::count(decodes.begin(), decodes.end(), true);
    checks.push_back(
        {"stream", subject, "an error, no memory allocated",
         fmt::format("{}: {} of {} refused", claim, decodes.size() - taken, decodes.size()),
         honest && taken == 0});
  };
  add("counts of 2^32", "octree points",
      {forged_decodes(header(Codec::octree, 1, kMost), chunk(1, 1), {0b11}),
       forged_decodes(header(Codec::octree, 21, kMost), chunk(7, 1), {0b11})});
  add("counts of 2^32", "octree masks",
      {forged_decodes(header(Codec::octree, 7, 1u << 26), chunk(7, kMost), {1}),
       forged_decodes(header(Codec::octree, 7, 1u << 26), chunk(7, kMost, Entropy::zstd), {1})});
  add("counts of 2^32", "Draco points",
      {forged_decodes(header(Codec::draco, 11, kMost), chunk(0, 8), Bytes(8, 0)),
       forged_decodes(header(Codec::draco, 11, kMost), chunk(0, kMost), Bytes(8, 0))});
  const char* levels = "level sizes that disagree with popcounts";
  add(levels, "too few, too many, childless, off by one leaf",
      {forged_decodes(header(Codec::octree, 2, 2), chunk(2, 2), {0b11, 1}),
       forged_decodes(header(Codec::octree, 2, 2), chunk(2, 4), {0b11, 1, 1, 1}),
       forged_decodes(header(Codec::octree, 2, 2), chunk(2, 3), {0b11, 0, 0b11}),
       forged_decodes(header(Codec::octree, 1, 3), chunk(1, 1), {0b11}),
       forged_decodes(header(Codec::octree, 1, 1), chunk(1, 1), {0b11})});
}

void check_mixed(Checks& checks) {
  const Cube cube{glm::dvec3(-0.5), 1.0};
  const EncodeOptions options{OctreeOptions{Entropy::none, DepthRule::fixed(9)}};
  const auto a = encode_frame(ball_cloud(300), cube, options);
  const auto b = encode_frame(ball_cloud(301), cube, options);
  std::size_t tried = 0, refused = 0;
  for (std::size_t layer = 0; a && b && layer < a->layers.size(); ++layer) {
    const auto own = layer_views(a->layers), other = layer_views(b->layers);
    for (const auto part :
         {&Chunks<ByteView>::geometry, &Chunks<ByteView>::colors, &Chunks<ByteView>::normals}) {
      // With the other frame's first geometry, it would be the other frame.
      if (layer == 0 && part == &Chunks<ByteView>::geometry) continue;
      auto mixed = own;
      mixed[layer].*part = other[layer].*part;
      ++tried;
      refused += !decode_frame(mixed);
    }
  }
  checks.push_back({"stream", "chunks of two frames mixed", "an error",
                    fmt::format("{} of {} refused", refused, tried),
                    tried > 0 && refused == tried});
}

void check_files(Checks& checks) {
  const Bytes ply = ply_bytes(ball_cloud(20));
  std::size_t refused = 0;
  for (std::size_t size = 0; size < ply.size(); ++size) {
    refused += !read_cloud(ByteView(ply).first(size));
  }
  checks.push_back({"stream", "truncated at every byte", "an error",
                    fmt::format("PLY: {} of {} refused", refused, ply.size()),
                    read_cloud(ply) && refused == ply.size()});

  Manifest manifest;
  manifest.name = "reel";
  manifest.codec = "octree";
  manifest.entropy = "zstd";
  manifest.duration_us = 40000;
  manifest.depth_min = manifest.depth_max = 5;
  manifest.bounds = {glm::dvec3(0.0), glm::dvec3(1.0)};
  manifest.layer_names = {"base"};
  Segment segment;
  segment.times_us = {0};
  segment.points = {3};
  LayerFile base;
  base.path = "0000-base.bin";
  base.bytes = 100;
  base.checksum = 1;
  base.frames = {{100, 0, 0}};
  segment.layers.push_back(std::move(base));
  manifest.segments = {segment};
  std::string text = write_manifest(manifest);
  const auto whole = parse_manifest(text);
  while (!text.empty() && text.back() == '\n') text.pop_back();
  refused = 0;
  for (std::size_t size = 0; size < text.size(); ++size) {
    refused += !parse_manifest(std::string_view(text).substr(0, size));
  }
  checks.push_back({"stream", "truncated at every byte", "an error",
                    whole ? fmt::format("reel.json: {} of {} refused", refused, text.size())
                          : whole.error().message,
                    whole && refused == text.size()});
}

}  // namespace

Checks stream_checks() {
  Checks checks;
  for (const Setting& setting : settings(kDepth)) check_damage(setting, checks);
  check_forged(checks);
  check_mixed(checks);
  check_files(checks);
  return checks;
}

}  // namespace pointreel::stability
