#include "codec/octree/octree_codec.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codec/core/build.h"
#include "codec/octree/context_model.h"
#include "pointreel/chunks.h"
#include "pointreel/draco.h"
#include "pointreel/octree.h"

namespace pointreel::octree_codec_test {
namespace {

const DecodeLimits kLimits;

/// A bumpy closed surface inside the unit cube, with normals and colours.
PointCloud bumpy_sphere(std::size_t n, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  PointCloud cloud;
  while (cloud.size() < n) {
    const glm::vec3 p(unit(random), unit(random), unit(random));
    const float length = glm::length(p);
    if (length < 0.1f || length > 1.0f) continue;
    const glm::vec3 d = p / length;
    cloud.positions.push_back(d * (0.4f + 0.05f * std::sin(9.0f * d.x)) + 0.5f);
    cloud.normals.push_back(d);
    cloud.colors.push_back(glm::u16vec3((d * 0.5f + 0.5f) * 255.0f) * std::uint16_t{257});
  }
  return cloud;
}

PointCloud permuted(const PointCloud& cloud) {
  std::vector<std::size_t> order(cloud.size());
  std::iota(order.begin(), order.end(), 0);
  std::shuffle(order.begin(), order.end(), std::mt19937(99));
  PointCloud out;
  for (const std::size_t i : order) {
    out.positions.push_back(cloud.positions[i]);
    out.normals.push_back(cloud.normals[i]);
    out.colors.push_back(cloud.colors[i]);
  }
  return out;
}

EncodedFrame encode(const PointCloud& cloud, DepthRule depth, Entropy entropy = Entropy::zstd,
                    Cube cube = {}, int quality = kLosslessColorQuality) {
  auto frame = encode_octree(cloud, cube, {entropy, depth, quality, quality}, true, true);
  EXPECT_TRUE(frame) << frame.error().message;
  return frame.value_or(EncodedFrame{});
}

Bytes concatenated(const EncodedFrame& frame) {
  Bytes all;
  for (const Chunks<Bytes>& layer : frame.layers) {
    for (const Bytes* part : {&layer.geometry, &layer.colors, &layer.normals}) {
      all.insert(all.end(), part->begin(), part->end());
    }
  }
  return all;
}

double degrees_between(const glm::vec3& a, const glm::vec3& b) {
  return glm::degrees(std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)));
}

class OctreeCodec : public testing::TestWithParam<Entropy> {};
INSTANTIATE_TEST_SUITE_P(Entropies, OctreeCodec,
                         testing::Values(Entropy::none, Entropy::zstd, Entropy::context),
                         [](const auto& entropy) { return name(entropy.param); });

TEST_P(OctreeCodec, restores_the_voxels_of_the_encoder_at_every_depth) {
  const PointCloud cloud = bumpy_sphere(3000);
  for (const int depth : {0, 1, 7, 8, 9, 10, 15, kMaxDepth}) {
    const EncodedFrame frame = encode(cloud, DepthRule::fixed(depth), GetParam());
    const auto tree = decode_octree_tree(layer_views(frame.layers), kLimits);
    ASSERT_TRUE(tree) << depth << ": " << tree.error().message;
    const Svo expected = build_svo(sort_points(cloud, Cube{}), depth);
    EXPECT_EQ(tree->svo.masks, expected.masks);
    EXPECT_EQ(tree->svo.first_child, expected.first_child);
    EXPECT_EQ(tree->svo.level_begin, expected.level_begin);
    EXPECT_EQ(tree->header.source_points, cloud.size());
  }
}

TEST_P(OctreeCodec, bytes_do_not_depend_on_the_order_of_the_points) {
  const PointCloud cloud = bumpy_sphere(5000);
  const EncodedFrame a = encode(cloud, DepthRule::fixed(6), GetParam());
  const EncodedFrame b = encode(permuted(cloud), DepthRule::fixed(6), GetParam());
  EXPECT_EQ(concatenated(a), concatenated(b));
}

TEST_P(OctreeCodec, restores_centres_within_half_a_cell_and_exact_colours) {
  PointCloud cloud = bumpy_sphere(4000);
  cloud.origin = {1e6, -3e6, 12.5};
  const Cube cube{cloud.origin, 1.0};
  const EncodedFrame encoded = encode(cloud, DepthRule::fixed(kMaxDepth), GetParam(), cube);
  const auto frame = decode_octree(layer_views(encoded.layers), kLimits);
  ASSERT_TRUE(frame) << frame.error().message;
  const SortedPoints sorted = sort_points(cloud, cube);
  ASSERT_EQ(frame->cloud.size(), cloud.size());
  for (std::size_t leaf = 0; leaf < cloud.size(); ++leaf) {
    const std::uint32_t point = sorted.points[leaf].index;
    const glm::dvec3 error = glm::abs(frame->cloud.world(leaf) - cloud.world(point));
    // Half a cell, plus the last bit of a float below one.
    EXPECT_LE(std::max({error.x, error.y, error.z}), std::ldexp(0.5, -kMaxDepth) + 6e-8);
    EXPECT_EQ(frame->cloud.colors[leaf], cloud.colors[point]);
    EXPECT_LT(degrees_between(frame->cloud.normals[leaf], cloud.normals[point]), 1.0);
  }
}

TEST(OctreeCodecNone, stores_exactly_one_byte_an_internal_node) {
  PointCloud cloud = bumpy_sphere(3000);
  const EncodedFrame frame = encode(cloud, DepthRule::fixed(10), Entropy::none);
  const Svo svo = build_svo(sort_points(cloud, Cube{}), 10);
  std::size_t payload = 0;
  for (const Chunks<Bytes>& layer : frame.layers)
    payload += layer.geometry.size() - kChunkHeaderSize;
  EXPECT_EQ(payload - kFrameHeaderSize, svo.internal_count());
}

TEST(OctreeCodecLayers, each_prefix_is_the_tree_truncated_with_its_mean_colours) {
  const PointCloud cloud = bumpy_sphere(20000);
  const EncodedFrame frame = encode(cloud, DepthRule::fixed(11));
  ASSERT_EQ(frame.layers.size(), 3u);
  const SortedPoints sorted = sort_points(cloud, Cube{});
  const Svo whole = build_svo(sorted, 11);
  const NodeAttributes means = mean_attributes(whole, cloud, sorted);
  for (std::size_t layers = 1; layers <= 3; ++layers) {
    auto prefix = layer_views(frame.layers);
    prefix.resize(layers);
    const auto tree = decode_octree_tree(prefix, kLimits);
    ASSERT_TRUE(tree) << tree.error().message;
    const int depth = last_level_of_layer(static_cast<int>(layers) - 1, 11);
    const Svo expected = truncate(whole, depth);
    EXPECT_EQ(tree->svo.masks, expected.masks);
    ASSERT_EQ(tree->colors.size(), expected.leaf_count());
    const std::size_t first = expected.internal_count();
    for (std::size_t i = 0; i < tree->colors.size(); ++i) {
      const glm::ivec3 error =
          glm::abs(glm::ivec3(tree->colors[i]) - glm::ivec3(means.colors[first + i]));
      EXPECT_LE(std::max({error.x, error.y, error.z}), 128);  // half an 8-bit step
    }
  }
}

TEST(OctreeCodecLayers, a_layer_without_attributes_inherits_those_above_it) {
  const PointCloud cloud = bumpy_sphere(2000);
  const EncodedFrame frame = encode(cloud, DepthRule::fixed(9));
  auto layers = layer_views(frame.layers);
  layers[1].colors = {};
  layers[1].normals = {};
  const auto tree = decode_octree_tree(layers, kLimits);
  ASSERT_TRUE(tree) << tree.error().message;
  auto base = layer_views(frame.layers);
  base.resize(1);
  const auto coarse = decode_octree_tree(base, kLimits);
  ASSERT_TRUE(coarse);
  ASSERT_EQ(tree->colors.size(), tree->svo.leaf_count());
  const std::vector<glm::uvec3> fine_cells = leaf_cells(tree->svo);
  const std::vector<glm::uvec3> coarse_cells = leaf_cells(coarse->svo);
  std::size_t parent = 0;
  for (std::size_t i = 0; i < fine_cells.size(); ++i) {
    while (coarse_cells[parent] != fine_cells[i] / 4u) ++parent;
    ASSERT_EQ(tree->colors[i], coarse->colors[parent]);
  }
  layers[0].colors = {};
  layers[0].normals = {};
  const auto bare = decode_octree_tree(layers, kLimits);
  ASSERT_TRUE(bare);
  EXPECT_TRUE(bare->colors.empty());
  EXPECT_TRUE(bare->normals.empty());
}

TEST(OctreeCodecAttributes, colours_become_more_accurate_with_quality) {
  const PointCloud cloud = bumpy_sphere(20000);
  const auto lossless =
      decode_octree(layer_views(encode(cloud, DepthRule::fixed(9)).layers), kLimits);
  ASSERT_TRUE(lossless);
  double last = HUGE_VAL;
  for (const int quality : {10, 30, 50, 70, 90, kLosslessColorQuality}) {
    const EncodedFrame encoded = encode(cloud, DepthRule::fixed(9), Entropy::zstd, {}, quality);
    const auto frame = decode_octree(layer_views(encoded.layers), kLimits);
    ASSERT_TRUE(frame) << frame.error().message;
    double error = 0.0;
    for (std::size_t i = 0; i < frame->cloud.size(); ++i) {
      const glm::dvec3 d =
          glm::dvec3(frame->cloud.colors[i]) - glm::dvec3(lossless->cloud.colors[i]);
      error += glm::dot(d, d);
    }
    EXPECT_LT(error, last) << quality;
    last = error;
  }
  EXPECT_EQ(last, 0.0);
}

TEST(OctreeCodecAttributes, normals_become_more_accurate_with_quality_and_are_unit_or_unknown) {
  PointCloud cloud = bumpy_sphere(20000);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (cloud.positions[i].x > 0.7f) cloud.normals[i] = glm::vec3(0);  // normals here are unknown
  }
  double last = HUGE_VAL;
  for (const int quality : {30, 50, 70, 90}) {
    const EncodedFrame encoded = encode(cloud, DepthRule::fixed(9), Entropy::zstd, {}, quality);
    const auto frame = decode_octree(layer_views(encoded.layers), kLimits);
    ASSERT_TRUE(frame) << frame.error().message;
    double sum = 0.0;
    std::size_t known = 0;
    for (std::size_t i = 0; i < frame->cloud.size(); ++i) {
      const glm::vec3& normal = frame->cloud.normals[i];
      if (normal == glm::vec3(0)) {
        EXPECT_GT(frame->cloud.positions[i].x, 0.65f);
        continue;
      }
      EXPECT_NEAR(glm::length(normal), 1.0f, 1e-5f);
      if (frame->cloud.positions[i].x > 0.69f) continue;
      sum += degrees_between(normal, frame->cloud.positions[i] - 0.5f);
      ++known;
    }
    EXPECT_GT(known, frame->cloud.size() / 2);
    EXPECT_LT(sum, last) << quality;
    last = sum;
  }
}

TEST(OctreeCodecAttributes, refuses_a_quality_out_of_range) {
  for (const int quality : {-1, 0, 101}) {
    EXPECT_FALSE(encode_octree(bumpy_sphere(10), Cube{},
                               {Entropy::none, DepthRule::fixed(3), quality}, true, true));
    EXPECT_FALSE(encode_octree(bumpy_sphere(10), Cube{},
                               {Entropy::none, DepthRule::fixed(3), 50, quality}, true, true));
  }
}

TEST(OctreeCodecAttributes, lossy_colours_after_a_layer_without_them_are_inherited) {
  const EncodedFrame frame =
      encode(bumpy_sphere(20000), DepthRule::fixed(10), Entropy::zstd, {}, 60);
  auto base = layer_views(frame.layers);
  for (std::size_t layer = 1; layer < 3; ++layer) base[layer].colors = {};
  const auto expected = decode_octree_tree(base, kLimits);
  auto gap = layer_views(frame.layers);
  gap[1].colors = {};
  const auto tree = decode_octree_tree(gap, kLimits);
  ASSERT_TRUE(expected && tree);
  EXPECT_EQ(tree->colors, expected->colors);
  gap[0].colors = {};
  const auto bare = decode_octree_tree(gap, kLimits);
  ASSERT_TRUE(bare);
  EXPECT_TRUE(bare->colors.empty());
}

TEST(OctreeCodecAttributes, keeps_16_bit_colours_and_unknown_normals) {
  PointCloud cloud;
  cloud.positions = {{0.1f, 0.1f, 0.1f}, {0.9f, 0.9f, 0.9f}};
  cloud.colors = {{1, 65535, 12345}, {54321, 2, 0}};
  cloud.normals = {{0, 0, 0}, {0, 0, -1}};
  const auto frame = decode_octree(layer_views(encode(cloud, DepthRule::fixed(3)).layers), kLimits);
  ASSERT_TRUE(frame) << frame.error().message;
  EXPECT_EQ(frame->cloud.colors, cloud.colors);
  EXPECT_EQ(frame->cloud.normals[0], glm::vec3(0));
  EXPECT_LT(degrees_between(frame->cloud.normals[1], cloud.normals[1]), 1.0);
}

TEST(OctreeCodecAttributes, lossy_16_bit_colours_are_not_rounded_to_8) {
  PointCloud cloud = bumpy_sphere(3000);
  for (glm::u16vec3& color : cloud.colors) color = {12345, 54321, 32000};
  const EncodedFrame encoded = encode(cloud, DepthRule::fixed(8), Entropy::zstd, {}, 60);
  const auto frame = decode_octree(layer_views(encoded.layers), kLimits);
  ASSERT_TRUE(frame) << frame.error().message;
  double sum = 0.0;
  for (const glm::u16vec3& color : frame->cloud.colors) {
    sum += std::abs(int{color.b} - int{cloud.colors[0].b});
  }
  EXPECT_LT(sum / static_cast<double>(frame->cloud.size()), 32.0);  // 8-bit rounding would give 125
}

TEST(OctreeCodecAttributes, decoding_stops_before_the_chunk_at_which_it_is_asked_to) {
  const EncodedFrame encoded =
      encode(bumpy_sphere(20000), DepthRule::fixed(10), Entropy::context, {}, 60);
  // Three layers, each with geometry, colours and normals.
  for (int chunks = 0; chunks <= 9; ++chunks) {
    int asked = 0;
    DecodeLimits limits;
    limits.stopped = [&] { return asked++ == chunks; };
    const auto decoded = decode_octree(layer_views(encoded.layers), limits);
    ASSERT_EQ(decoded.has_value(), chunks == 9);
    if (!decoded) {
      EXPECT_EQ(decoded.error().code, ErrorCode::cancelled);
    }
  }
}

TEST(OctreeCodecAttributes, nodes_below_the_last_level_of_normals_have_those_of_their_ancestors) {
  const EncodedFrame encoded =
      encode(bumpy_sphere(20000), DepthRule::fixed(10), Entropy::context, {}, 60);
  DecodeLimits limits;
  limits.inner_nodes = true;
  limits.leaves = false;
  const auto whole = decode_octree(layer_views(encoded.layers), limits);
  ASSERT_TRUE(whole) << whole.error().message;
  const Svo& svo = *whole->svo;
  for (const int depth : {-1, 0, 6, 9}) {
    limits.normals_depth = depth;
    const auto tree = decode_octree(layer_views(encoded.layers), limits);
    ASSERT_TRUE(tree) << tree.error().message;
    EXPECT_EQ(tree->attributes.colors, whole->attributes.colors);
    const std::vector<glm::i16vec3>& normals = tree->attributes.normals;
    ASSERT_EQ(normals.size(), svo.node_count());
    const std::uint32_t own = svo.level_begin[static_cast<std::size_t>(std::max(depth, 0)) + 1];
    EXPECT_TRUE(
        std::equal(normals.begin(), normals.begin() + own, whole->attributes.normals.begin()));
    for (std::uint32_t node = 0; node < svo.internal_count(); ++node) {
      for (int child = 0; child < std::popcount(svo.masks[node]); ++child) {
        const std::uint32_t number = svo.first_child[node] + static_cast<std::uint32_t>(child);
        if (number < own) continue;
        ASSERT_EQ(normals[number], normals[node]) << number;
      }
    }
  }
}

TEST(OctreeCodecAttributes, a_tree_limited_to_a_level_equals_the_full_tree_down_to_it) {
  const PointCloud cloud = bumpy_sphere(20000);
  for (const int quality : {60, 100}) {
    const EncodedFrame encoded = encode(cloud, DepthRule::fixed(10), Entropy::zstd, {}, quality);
    DecodeLimits limits;
    limits.inner_nodes = true;
    const auto whole = decode_octree(layer_views(encoded.layers), limits);
    ASSERT_TRUE(whole) << whole.error().message;
    EXPECT_EQ(whole->depth, 10);
    limits.leaves = false;
    for (const int depth : {0, 5, 7, 8, 9, 10, 11}) {
      limits.depth = depth;
      const auto tree = decode_octree(layer_views(encoded.layers), limits);
      ASSERT_TRUE(tree) << tree.error().message;
      EXPECT_TRUE(tree->cloud.empty() && !tree->cloud.has_colors());
      EXPECT_EQ(tree->depth, 10);
      const Svo expected = truncate(*whole->svo, depth);
      EXPECT_EQ(tree->svo->depth, expected.depth);
      EXPECT_EQ(tree->svo->masks, expected.masks);
      const std::size_t nodes = expected.node_count();
      ASSERT_EQ(tree->attributes.colors.size(), nodes);
      ASSERT_EQ(tree->attributes.normals.size(), nodes);
      // Coded losslessly, the colours of a layer are those of its leaves, which are means of means.
      if (quality == 100 && depth < 10) continue;
      EXPECT_TRUE(std::equal(tree->attributes.colors.begin(), tree->attributes.colors.end(),
                             whole->attributes.colors.begin()));
      EXPECT_TRUE(std::equal(tree->attributes.normals.begin(), tree->attributes.normals.end(),
                             whole->attributes.normals.begin()));
    }
  }
}

TEST(OctreeCodecAttributes, nodes_have_the_normals_of_their_leaves_including_unknown_ones) {
  PointCloud cloud = bumpy_sphere(5000);
  const double middle = bounds(cloud).center().x;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (i % 2 == 0 && cloud.world(i).x > middle) cloud.normals[i] = glm::vec3(0.0f);
  }
  for (const int quality : {50, 100}) {
    OctreeOptions options;
    options.depth = DepthRule::fixed(9);
    options.normal_quality = quality;
    const auto encoded = encode_frame(cloud, bounding_cube(bounds(cloud)), {options});
    ASSERT_TRUE(encoded);
    DecodeLimits limits;
    limits.inner_nodes = true;
    const auto frame = decode_octree(layer_views(encoded->layers), limits);
    ASSERT_TRUE(frame) << frame.error().message;
    std::size_t unknown = 0;
    for (std::size_t i = 0; i < frame->cloud.size(); ++i) {
      const glm::i16vec3 node = frame->attributes.normals[frame->svo->internal_count() + i];
      const glm::vec3 leaf = 32767.0f * frame->cloud.normals[i];
      ASSERT_LE(glm::length(leaf - glm::vec3(node)), 1.5f);
      unknown += node == glm::i16vec3(0);
    }
    EXPECT_GT(unknown, 500u);
    EXPECT_LT(unknown, 2000u);
  }
}

TEST(OctreeCodecAttributes, inner_nodes_have_nearly_the_means_of_their_leaves) {
  const PointCloud cloud = bumpy_sphere(20000);
  const EncodedFrame encoded = encode(cloud, DepthRule::fixed(10), Entropy::zstd, {}, 90);
  DecodeLimits limits;
  const auto without = decode_octree(layer_views(encoded.layers), limits);
  ASSERT_TRUE(without) << without.error().message;
  EXPECT_TRUE(without->attributes.colors.empty() && without->attributes.normals.empty());
  limits.inner_nodes = true;
  for (std::size_t layers = 1; layers <= 3; ++layers) {
    auto prefix = layer_views(encoded.layers);
    prefix.resize(layers);
    const auto frame = decode_octree(prefix, limits);
    ASSERT_TRUE(frame) << frame.error().message;
    const NodeAttributes& nodes = frame->attributes;
    const NodeAttributes means = mean_attributes(*frame->svo, frame->cloud);
    ASSERT_EQ(nodes.colors.size(), means.colors.size());
    ASSERT_EQ(nodes.normals.size(), means.normals.size());
    const std::size_t leaves = frame->svo->internal_count();
    double angle = 0.0;
    for (std::size_t i = 0; i < nodes.colors.size(); ++i) {
      const glm::ivec3 d = glm::abs(glm::ivec3(nodes.colors[i]) - glm::ivec3(means.colors[i]));
      // All nodes of a layer have the same weight, however many leaves are below them.
      ASSERT_LE(std::max({d.x, d.y, d.z}), i < leaves ? 6 * 257 : 0) << i;
      angle += degrees_between(glm::vec3(nodes.normals[i]), glm::vec3(means.normals[i]));
    }
    EXPECT_LT(angle / static_cast<double>(nodes.colors.size()), 0.5);
  }
}

TEST(OctreeCodecAttributes, normals_in_all_directions_err_by_less_than_a_degree) {
  double worst = 0.0;
  std::mt19937 random(5);
  std::normal_distribution<float> gauss;
  PointCloud cloud;
  for (int i = 0; i < 20000; ++i) {
    const glm::vec3 n = glm::normalize(glm::vec3(gauss(random), gauss(random), gauss(random)));
    cloud.positions.push_back(n * 0.5f + 0.5f);
    cloud.normals.push_back(n);
  }
  const auto frame =
      decode_octree(layer_views(encode(cloud, DepthRule::fixed(kMaxDepth)).layers), kLimits);
  ASSERT_TRUE(frame);
  const SortedPoints sorted = sort_points(cloud, Cube{});
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    worst = std::max(
        worst, degrees_between(frame->cloud.normals[i], cloud.normals[sorted.points[i].index]));
  }
  EXPECT_LT(worst, 1.0);
}

TEST(OctreeCodecHardCases, an_empty_cloud_is_a_frame_that_plays_as_nothing) {
  const EncodedFrame encoded = encode(PointCloud{}, DepthRule::by_delta(0.05));
  EXPECT_EQ(encoded.layers.size(), 1u);
  const auto frame = decode_octree(layer_views(encoded.layers), kLimits);
  ASSERT_TRUE(frame) << frame.error().message;
  EXPECT_TRUE(frame->cloud.empty());
  EXPECT_EQ(frame->svo->node_count(), 0u);
}

TEST(OctreeCodecHardCases, identical_points_are_one_cell) {
  PointCloud cloud;
  cloud.positions.assign(1000, glm::vec3(0.25f));
  const EncodedFrame encoded = encode(cloud, DepthRule::by_delta(0.0));
  EXPECT_EQ(encoded.coded_points, 1u);
  const auto frame = decode_octree(layer_views(encoded.layers), kLimits);
  ASSERT_TRUE(frame) << frame.error().message;
  EXPECT_EQ(frame->cloud.size(), 1u);
  EXPECT_EQ(frame->source_points, 1000u);
}

TEST(OctreeCodecHardCases, an_invalid_delta_is_refused) {
  const OctreeOptions options{Entropy::none, DepthRule::by_delta(std::nan(""))};
  EXPECT_FALSE(encode_octree(bumpy_sphere(10), Cube{}, options, true, true));
}

// --- hostile bytes ---

/// The codings of geometry, each with lossless and with lossy colours.
class OctreeCodecHostile : public testing::TestWithParam<std::pair<Entropy, int>> {};
INSTANTIATE_TEST_SUITE_P(Codings, OctreeCodecHostile,
                         testing::Values(std::pair{Entropy::zstd, kLosslessColorQuality},
                                         std::pair{Entropy::context, 80}),
                         [](const auto& coding) { return name(coding.param.first); });

TEST_P(OctreeCodecHostile, layers_of_different_frames_are_not_mixed) {
  const DepthRule depth = DepthRule::fixed(9);
  const EncodedFrame a =
      encode(bumpy_sphere(500, 1), depth, GetParam().first, {}, GetParam().second);
  const EncodedFrame b =
      encode(bumpy_sphere(500, 2), depth, GetParam().first, {}, GetParam().second);
  auto mixed = layer_views(a.layers);
  mixed[1].geometry = layer_views(b.layers)[1].geometry;
  EXPECT_FALSE(decode_octree(mixed, kLimits));
  mixed = layer_views(a.layers);
  std::swap(mixed[0].colors, mixed[1].colors);
  EXPECT_FALSE(decode_octree(mixed, kLimits));
}

/// A frame whose checksums are right, whatever else it claims.
Bytes forged(FrameHeader header, ChunkHeader chunk, const Bytes& payload) {
  Bytes bytes;
  write_frame_header(header, 7, bytes);
  write_chunk(chunk, 7, payload, bytes);
  return bytes;
}

FrameHeader small_header(std::uint8_t depth, std::uint32_t points) {
  FrameHeader header;
  header.depth = depth;
  header.source_points = header.coded_points = points;
  return header;
}

TEST(OctreeCodecForged, forged_counts_are_refused_before_memory_is_allocated) {
  const auto decodes = [](const Bytes& bytes) {
    return decode_octree_tree({{bytes, {}, {}}}, kLimits).has_value();
  };
  const auto chunk = [](std::uint8_t last_level, std::uint32_t raw_size,
                        Entropy entropy = Entropy::none) {
    return ChunkHeader{ChunkKind::geometry, entropy, 0, last_level, raw_size};
  };
  EXPECT_TRUE(decodes(forged(small_header(1, 2), chunk(1, 1), {0b11})));
  // Counts of 2^32 - 1.
  EXPECT_FALSE(decodes(forged(small_header(1, 0xffffffffu), chunk(1, 1), {0b11})));
  EXPECT_FALSE(decodes(forged(small_header(7, 1u << 26), chunk(7, 0xffffffffu), {1})));
  EXPECT_FALSE(
      decodes(forged(small_header(7, 1u << 26), chunk(7, 0xffffffffu, Entropy::zstd), {1})));
  // Level sizes that disagree with the popcounts.
  EXPECT_FALSE(decodes(forged(small_header(2, 2), chunk(2, 2), {0b11, 1})));
  EXPECT_FALSE(decodes(forged(small_header(2, 2), chunk(2, 4), {0b11, 1, 1, 1})));
  EXPECT_FALSE(decodes(forged(small_header(2, 2), chunk(2, 3), {0b11, 0, 0b11})));
  // A leaf count that disagrees with the header.
  EXPECT_FALSE(decodes(forged(small_header(1, 3), chunk(1, 1), {0b11})));
  EXPECT_FALSE(decodes(forged(small_header(1, 1), chunk(1, 1), {0b11})));
  // A layer that ends at another level, nodes in an empty frame, and a level that does not exist.
  EXPECT_FALSE(decodes(forged(small_header(2, 2), chunk(1, 1), {0b11})));
  EXPECT_FALSE(decodes(forged(small_header(0, 0), chunk(0, 1), {1})));
  EXPECT_FALSE(decodes(forged(small_header(5, 0), chunk(5, 0), {})));
  EXPECT_FALSE(decodes(forged(small_header(22, 2), chunk(7, 1), {0b11})));
}

TEST(OctreeCodecForged, damaged_contexts_are_refused) {
  const auto decodes = [](std::uint32_t points, std::uint32_t masks, const Bytes& payload) {
    const ChunkHeader chunk{ChunkKind::geometry, Entropy::context, 0, 7, masks};
    return decode_octree_tree({{forged(small_header(7, points), chunk, payload), {}, {}}}, kLimits)
        .has_value();
  };
  const Bytes zeros(100, 0);
  const Bytes classes = {1, 5, 5, 5, 5, 5, 5, 5};
  EXPECT_FALSE(decodes(1u << 20, 7, {})) << "the tables are missing";
  EXPECT_FALSE(decodes(1u << 20, 7, {1})) << "the classes are missing";
  EXPECT_FALSE(decodes(1u << 20, 7, {2, 5, 5, 5, 5, 5, 5, 5, 0})) << "the tables are unknown";
  EXPECT_FALSE(decodes(1u << 20, 0, classes)) << "the masks are missing";
  EXPECT_FALSE(decodes(1u << 26, 64 * 1024 + 1024 * 8 + 1, classes)) << "more than the bytes allow";
  EXPECT_FALSE(decodes(1u << 20, 299'593, zeros)) << "tables 0 are unknown";
  // This many masks are no tree.
  EXPECT_FALSE(decodes(1u << 21, 64 * 1024, classes));
}

TEST(OctreeCodecContext, is_smaller_than_zstd_and_contains_no_second_coding) {
  const PointCloud cloud = bumpy_sphere(20000);
  const EncodedFrame context = encode(cloud, DepthRule::fixed(8), Entropy::context);
  const EncodedFrame zstd = encode(cloud, DepthRule::fixed(8), Entropy::zstd);
  std::size_t sizes[2] = {};
  for (std::size_t i = 0; i < 2; ++i) {
    sizes[0] += context.layers[i].geometry.size();
    sizes[1] += zstd.layers[i].geometry.size();
  }
  EXPECT_LT(static_cast<double>(sizes[0]), 0.9 * static_cast<double>(sizes[1]));
  auto mixed = layer_views(context.layers);
  mixed[1].geometry = layer_views(zstd.layers)[1].geometry;
  EXPECT_FALSE(decode_octree_tree(mixed, kLimits));
  mixed = layer_views(zstd.layers);
  mixed[1].geometry = layer_views(context.layers)[1].geometry;
  EXPECT_FALSE(decode_octree_tree(mixed, kLimits));
}

/// Tables with one alphabet each, in place of tables that come with the frames.
std::shared_ptr<const ContextTables> plain_tables(std::uint64_t checksum) {
  const std::vector<StoredTable> plain(kTables, {0, {0}, {0}, {{}}});
  auto tables = parse_tables(write_tables(std::span<const StoredTable, kTables>(plain))).value();
  tables.checksum = checksum;
  return std::make_shared<const ContextTables>(std::move(tables));
}

TEST(OctreeCodecContext, decodes_frames_only_with_the_tables_that_they_were_coded_with) {
  const PointCloud cloud = bumpy_sphere(2000);
  const auto tables = plain_tables(7), others = plain_tables(8);
  OctreeOptions options{Entropy::context, DepthRule::fixed(9)};
  const auto built_in = encode_octree(cloud, Cube{}, options, false, false);
  options.tables = tables;
  const auto given = encode_octree(cloud, Cube{}, options, false, false);
  ASSERT_TRUE(built_in && given);
  const auto decode = [](const EncodedFrame& frame, const ContextTables* with) {
    DecodeLimits limits;
    limits.tables = with;
    return decode_octree_tree(layer_views(frame.layers), limits);
  };
  ASSERT_TRUE(decode(*given, tables.get()));
  EXPECT_EQ(decode(*given, tables.get())->svo.masks, decode(*built_in, nullptr)->svo.masks);
  EXPECT_TRUE(decode(*built_in, tables.get())) << "a frame may still name built-in tables";
  EXPECT_THAT(decode(*given, nullptr).error().message, testing::HasSubstr("are not there"));
  EXPECT_THAT(decode(*given, others.get()).error().message, testing::HasSubstr("other"));
}

TEST(OctreeCodecContext, pads_chunks_that_would_exceed_the_expansion_limit_of_readers) {
  PointCloud solid;
  for (int i = 0; i < 1 << 18; ++i) {
    solid.positions.push_back((glm::vec3(i & 63, i >> 6 & 63, i >> 12) + 0.5f) / 64.0f);
  }
  const EncodedFrame frame = encode(solid, DepthRule::fixed(6), Entropy::context);
  const auto tree = decode_octree_tree(layer_views(frame.layers), kLimits);
  ASSERT_TRUE(tree) << tree.error().message;
  EXPECT_EQ(tree->svo.leaf_count(), solid.size());
}

TEST(OctreeCodecForged, an_invalid_cube_is_refused) {
  const ChunkHeader chunk{ChunkKind::geometry, Entropy::none, 0, 1, 1};
  for (const double edge : {0.0, -1.0, std::nan(""), HUGE_VAL, 5e-324, 1e31}) {
    EXPECT_FALSE(encode_octree(bumpy_sphere(10), {glm::dvec3(0), edge}, {}, true, true)) << edge;
    FrameHeader header = small_header(1, 2);
    header.cube.edge = edge;
    EXPECT_FALSE(decode_octree_tree({{forged(header, chunk, {0b11}), {}, {}}}, kLimits)) << edge;
  }
}

TEST(OctreeCodecForged, more_points_than_the_limit_are_refused) {
  const EncodedFrame frame = encode(bumpy_sphere(500), DepthRule::fixed(9));
  EXPECT_FALSE(decode_octree(layer_views(frame.layers), {frame.coded_points - 1}));
  EXPECT_TRUE(decode_octree(layer_views(frame.layers), {frame.coded_points}));
}

}  // namespace
}  // namespace pointreel::octree_codec_test
