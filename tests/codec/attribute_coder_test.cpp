#include "codec/octree/attribute_coder.h"

#include <cmath>
#include <random>
#include <tuple>

#include <gtest/gtest.h>

#include "codec/core/build.h"
#include "codec/octree/coefficient_quantizer.h"
#include "codec/octree/color_space.h"
#include "codec/octree/normal_space.h"
#include "codec/octree/raht.h"
#include "codec/octree/tangent_frame.h"
#include "tests/reference/color_decoder.h"

namespace pointreel::attribute_coder_test {
namespace {

/// A bumpy closed surface whose colours are waves and noise.
PointCloud colored_sphere(std::size_t n, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<float> gauss;
  PointCloud cloud;
  for (std::size_t i = 0; i < n; ++i) {
    const glm::vec3 d = glm::normalize(glm::vec3(gauss(random), gauss(random), gauss(random)));
    cloud.positions.push_back(d * (0.4f + 0.05f * std::sin(9.0f * d.x)) + 0.5f);
    const glm::vec3 wave = 0.5f + 0.3f * glm::sin(20.0f * d) + 0.03f * gauss(random);
    cloud.colors.push_back(glm::u16vec3(glm::clamp(wave, 0.0f, 1.0f) * 255.0f) *
                           std::uint16_t{257});
  }
  return cloud;
}

/// A tree, the colours of its leaves, and how it is cut into layers.
struct Sample {
  Svo svo;
  std::vector<glm::u16vec3> colors;
  std::vector<int> layer_ends;

  FrameStructure structure() const { return {svo, layer_ends}; }
};

Sample sample(std::size_t points, int depth, std::vector<int> layer_ends) {
  const PointCloud cloud = colored_sphere(points);
  const SortedPoints sorted = sort_points(cloud, Cube{});
  Sample made{build_svo(sorted, depth), {}, std::move(layer_ends)};
  made.colors = mean_leaf_colors(made.svo, cloud, sorted);
  return made;
}

std::vector<Bytes> encode(const Sample& s, const CoefficientSteps& steps) {
  std::vector<Short4> leaves;
  for (const glm::u16vec3& color : s.colors) leaves.push_back(value_from_color(color));
  const FrameStructure structure = s.structure();
  TransformEncoder encoder(structure, AttributeKind::colors, leaves);
  std::vector<Bytes> layers;
  for (const int end : s.layer_ends) {
    layers.push_back(
        encoder.encode_layer(layer_steps(steps, s.svo.leaf_count(), s.svo.node_count(end))));
  }
  return layers;
}

std::vector<glm::u16vec3> colors(const TransformDecoder& decoder, int level) {
  std::vector<glm::u16vec3> all;
  for (const Short4& value : decoder.values(level)) all.push_back(color_from_value(value));
  return all;
}

/// Returns the colours at the end of the last of the given layers.
std::vector<glm::u16vec3> decode(const Sample& s, const std::vector<Bytes>& layers) {
  const Svo svo = truncate(s.svo, s.layer_ends[layers.size() - 1]);
  const auto count = static_cast<std::ptrdiff_t>(layers.size());
  const FrameStructure structure(svo, {s.layer_ends.begin(), s.layer_ends.begin() + count});
  TransformDecoder decoder(structure, AttributeKind::colors);
  for (std::size_t layer = 0; layer < layers.size(); ++layer) {
    const auto decoded = decoder.decode_layer(layers[layer], s.layer_ends[layer]);
    EXPECT_TRUE(decoded) << decoded.error().message;
  }
  return colors(decoder, svo.depth);
}

double mean_squared_luma_error(const std::vector<glm::u16vec3>& a,
                               const std::vector<glm::u16vec3>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double d = (ycbcr_from_rgb(a[i])[0] - ycbcr_from_rgb(b[i])[0]) / double{kValuesPerStep};
    sum += d * d;
  }
  return sum / static_cast<double>(a.size());
}

std::size_t total(const std::vector<Bytes>& layers) {
  std::size_t bytes = 0;
  for (const Bytes& layer : layers) bytes += layer.size();
  return bytes;
}

TEST(ColorSpace, restores_every_8_bit_colour_within_one_step) {
  for (int r = 0; r < 256; r += 5) {
    for (int g = 0; g < 256; g += 3) {
      for (int b = 0; b < 256; b += 15) {
        const glm::u16vec3 color(r * 257, g * 257, b * 257);
        EXPECT_EQ(rgb_from_ycbcr(ycbcr_from_rgb(color)), color);
      }
    }
  }
}

TEST(ColorSpace, gives_greys_no_chroma_and_clamps_values_outside_the_gamut) {
  for (int v = 0; v < 256; ++v) {
    const glm::u16vec3 grey(static_cast<std::uint16_t>(v * 257));
    const Int4 value = ycbcr_from_rgb(grey);
    EXPECT_EQ(value[0], v * kValuesPerStep);
    EXPECT_EQ(value[1], 0);
    EXPECT_EQ(value[2], 0);
  }
  EXPECT_EQ(rgb_from_ycbcr(Int4{16383, 16383, 16383, 1}), glm::u16vec3(65535, 0x5858, 65535));
  EXPECT_EQ(rgb_from_ycbcr(Int4{-16384, 0, 0, 1}), glm::u16vec3(0));
}

TEST(ColorSpace, of_exact_layers_restores_every_8_bit_colour) {
  for (int r = 0; r < 256; r += 5) {
    for (int g = 0; g < 256; ++g) {
      for (int b = 0; b < 256; b += 3) {
        const glm::u16vec3 color(r * 257, g * 257, b * 257);
        EXPECT_EQ(color_from_exact_value(exact_value_from_color(color)), color);
      }
    }
  }
  const Short4 beyond{{-16384, 16383, 16383, 1}};
  EXPECT_EQ(color_from_exact_value(beyond), glm::u16vec3(0));
}

/// Encodes without a loss, with colours that vary by up to `noise` from point to point.
std::pair<std::vector<Bytes>, std::vector<glm::u16vec3>> encode_exactly(const Sample& s,
                                                                        int noise) {
  std::mt19937 random(5);
  std::uniform_int_distribution<int> some(-noise, noise);
  std::vector<Short4> leaves;
  std::vector<glm::u16vec3> colors;
  for (const glm::u16vec3& color : s.colors) {
    const glm::ivec3 noisy =
        glm::ivec3(color) / 257 + glm::ivec3(some(random), some(random), some(random));
    colors.push_back(glm::u16vec3(glm::clamp(noisy, 0, 255) * 257));
    leaves.push_back(exact_value_from_color(colors.back()));
  }
  const FrameStructure structure = s.structure();
  TransformEncoder encoder(structure, AttributeKind::colors, leaves, true);
  std::vector<Bytes> layers;
  for (std::size_t i = 0; i < s.layer_ends.size(); ++i)
    layers.push_back(encoder.encode_layer(kExactSteps));
  return {std::move(layers), std::move(colors)};
}

TEST(ExactLayers, restore_all_colours_as_the_reference_does) {
  for (const auto& [depth, ends] :
       {std::pair(0, std::vector{0}), {4, {4}}, {8, {7, 8}}, {10, {3, 7, 10}}}) {
    const Sample s = sample(3000, depth, ends);
    for (const int noise : {0, 2, 20, 255}) {
      const auto [layers, colors] = encode_exactly(s, noise);
      const FrameStructure structure = s.structure();
      TransformDecoder decoder(structure, AttributeKind::colors);
      for (std::size_t i = 0; i < ends.size(); ++i) {
        ASSERT_TRUE(decoder.decode_layer(layers[i], ends[i]));
      }
      ASSERT_TRUE(decoder.exact());
      std::vector<glm::u16vec3> back;
      for (const Short4& v : decoder.values(depth)) back.push_back(color_from_exact_value(v));
      EXPECT_EQ(back, colors);
      EXPECT_EQ(reference::decode_colors(leaf_cells(s.svo), layers, ends), colors);
    }
  }
}

TEST(ExactLayers, give_inner_nodes_colours_close_to_the_means_of_their_leaves) {
  const Sample s = sample(3000, 9, {7, 9});
  const auto [layers, colors] = encode_exactly(s, 3);
  const FrameStructure structure = s.structure();
  TransformDecoder decoder(structure, AttributeKind::colors);
  ASSERT_TRUE(decoder.decode_layer(layers[0], 7));
  PointCloud leaves = leaf_centers(s.svo);
  leaves.colors = colors;
  const std::vector<glm::u16vec3> means = mean_attributes(s.svo, leaves).colors;
  for (std::uint32_t node = s.svo.level_begin[7]; node < s.svo.level_begin[8]; ++node) {
    const glm::ivec3 color(color_from_exact_value(decoder.values()[node]));
    const glm::ivec3 off = glm::abs(color - glm::ivec3(means[node]));
    EXPECT_LE(std::max({off.r, off.g, off.b}), 3 * 257) << node;
  }
}

TEST(ExactLayers, must_all_be_exact) {
  const Sample s = sample(500, 8, {7, 8});
  auto [layers, colors] = encode_exactly(s, 3);
  const FrameStructure structure = s.structure();
  TransformDecoder decoder(structure, AttributeKind::colors);
  ASSERT_TRUE(decoder.decode_layer(layers[0], 7));
  layers[1][1] ^= 0x80;
  EXPECT_FALSE(decoder.decode_layer(layers[1], 8));
  layers[1][1] ^= 0x80;
  EXPECT_TRUE(decoder.decode_layer(layers[1], 8));
}

TEST(CoefficientQuantizer, zeroes_coefficients_that_cost_more_bits_than_they_are_worth) {
  // Two children a little more than half a step apart.
  const NodeScales scales{make_scale(1, 1)};
  const PairSteps steps({1024, 1024, 1024});
  const std::int32_t step = step_of(scales[0], 1024) / 256;
  const auto quantized = [&](const CoefficientContexts& contexts, std::int32_t difference) {
    const Int4 differences{difference, 0, 0, 0};
    std::array<Triple, 7> q{};
    return quantize_node(1, scales, steps, &differences, contexts, {}, q) ? q[0][0] : 0;
  };
  CoefficientContexts rare, frequent;
  for (int i = 0; i < 100; ++i) {
    rare.first[0][0][0].update(0);
    frequent.first[0][0][0].update(1);
  }
  EXPECT_EQ(quantized(rare, step * 3 / 4), 0);
  EXPECT_EQ(quantized(frequent, step * 3 / 4), 1);
  EXPECT_EQ(quantized(rare, step * 3), 3);
  EXPECT_EQ(quantized(rare, -step * 3), -3);
  EXPECT_EQ(quantized(frequent, step / 2), 0);
}

TEST(PairScales, are_the_same_in_the_table_and_beside_it) {
  for (std::uint32_t w0 = 1; w0 <= 40; ++w0) {
    for (std::uint32_t w1 = 1; w1 <= 40; ++w1) {
      const PairScale scale = pair_scales()(w0, w1), made = make_scale(w0, w1);
      EXPECT_EQ(scale.ratio, made.ratio);
      EXPECT_EQ(scale.inverse, made.inverse);
      EXPECT_NEAR(scale.inverse / 131072.0, std::sqrt(1.0 / w0 + 1.0 / w1), 1e-5);
    }
  }
  const PairScale largest = make_scale(1u << 29, 1u << 29);
  EXPECT_EQ(largest.ratio, 1 << 13);
  EXPECT_EQ(step_of(largest, 65535), 512);
}

TEST(TangentFrame, turns_along_the_normal_into_the_third_component_and_back) {
  std::mt19937 random(9);
  std::normal_distribution<float> gauss;
  for (int i = 0; i < 2000; ++i) {
    const glm::vec3 n =
        8160.0f * glm::normalize(glm::vec3(gauss(random), gauss(random), gauss(random)));
    const Int4 normal{static_cast<int>(n.x), static_cast<int>(n.y), static_cast<int>(n.z), 0};
    const TangentFrame frame(normal);
    const Int4 along = frame.reflect(normal);
    EXPECT_LE(std::abs(along[0]), 8);
    EXPECT_LE(std::abs(along[1]), 8);
    EXPECT_NEAR(std::abs(along[2]), 8160, 8);
    const Int4 d{static_cast<int>(gauss(random) * 3000), static_cast<int>(gauss(random) * 3000),
                 static_cast<int>(gauss(random) * 3000), 0};
    const Int4 back = frame.reflect(frame.reflect(d));
    for (int k = 0; k < 3; ++k) EXPECT_LE(std::abs(back[k] - d[k]), 4);
  }
  const TangentFrame none(Int4{100, -300, 200, 0});
  EXPECT_EQ(none.reflect(Int4{5, -6, 7, 0})[1], -6);
}

TEST(AttributeCoder, a_larger_step_gives_a_larger_error_and_a_smaller_size) {
  const Sample s = sample(30000, 8, {7, 8});
  double last_error = 0.0;
  std::size_t last_size = ~std::size_t{0};
  for (const int step : {1, 2, 4, 8, 16, 32}) {
    const auto scaled = static_cast<std::uint16_t>(256 * step);
    const std::vector<Bytes> layers = encode(s, {scaled, scaled});
    const double error = mean_squared_luma_error(decode(s, layers), s.colors);
    // Rounding to 8 bits adds a twelfth. The dead zone adds up to a quarter of the squared step.
    EXPECT_LE(error, 0.25 * step * step + 0.2) << step;
    EXPECT_GT(error, last_error) << step;
    EXPECT_LT(total(layers), last_size) << step;
    last_error = error;
    last_size = total(layers);
  }
}

TEST(AttributeCoder, each_prefix_of_the_layers_decodes_to_nearly_the_mean_colours) {
  const Sample s = sample(40000, 11, {7, 9, 11});
  const std::vector<Bytes> layers = encode(s, {512, 512});
  const PointCloud cloud = colored_sphere(40000);
  const std::vector<glm::u16vec3> means = mean_colors(s.svo, cloud, sort_points(cloud, Cube{}));
  for (std::size_t count = 1; count <= 3; ++count) {
    const int level = s.layer_ends[count - 1];
    const auto colors = decode(s, {layers.begin(), layers.begin() + static_cast<long>(count)});
    const auto first = means.begin() + s.svo.level_begin[static_cast<std::size_t>(level)];
    const std::vector<glm::u16vec3> expected(first, first + s.svo.node_count(level));
    ASSERT_EQ(colors.size(), expected.size());
    EXPECT_LT(mean_squared_luma_error(colors, expected), 1.5) << level;
  }
}

TEST(AttributeCoder, agrees_with_the_slow_reference_decoder) {
  // Dense and sparse clouds, few and many layers, noise and flat colours.
  for (const auto& [points, depth, ends] :
       {std::tuple(3000, 6, std::vector<int>{6}), std::tuple(4000, 7, std::vector<int>{3, 5, 7}),
        std::tuple(700, 12, std::vector<int>{7, 9, 12}), std::tuple(5, 3, std::vector<int>{3})}) {
    Sample s = sample(static_cast<std::size_t>(points), depth, ends);
    for (const bool flat : {false, true}) {
      if (flat) {
        for (std::size_t i = 0; i < s.colors.size(); ++i) {
          s.colors[i] =
              i < s.colors.size() / 2 ? glm::u16vec3(65535, 0, 0) : glm::u16vec3(0, 65535, 0);
        }
      }
      for (const std::uint16_t step : std::initializer_list<std::uint16_t>{1, 700, 9000, 65535}) {
        const std::vector<Bytes> layers =
            encode(s, {step, static_cast<std::uint16_t>(step / 2 + 1)});
        EXPECT_EQ(decode(s, layers), reference::decode_colors(leaf_cells(s.svo), layers, ends))
            << points << " points, step " << step;
      }
    }
  }
}

/// The normals of the leaves, as a sphere has them with some noise; some are unknown.
std::vector<Short4> normals(const Sample& s) {
  std::mt19937 random(8);
  std::normal_distribution<float> gauss;
  std::vector<Short4> values;
  for (const glm::uvec3& cell : leaf_cells(s.svo)) {
    const glm::vec3 noise(gauss(random), gauss(random), gauss(random));
    const glm::vec3 n = glm::normalize(
        glm::normalize(glm::vec3(cell) - std::ldexp(0.5f, s.svo.depth)) + 0.2f * noise);
    values.push_back(
        value_from_normal(random() % 20 == 0 ? glm::i16vec3(0) : glm::i16vec3(n * 32767.0f)));
  }
  return values;
}

TEST(AttributeCoder, normals_agree_with_the_slow_reference_decoder) {
  for (const auto& [points, depth, ends] :
       {std::tuple(3000, 6, std::vector<int>{6}), std::tuple(4000, 7, std::vector<int>{3, 5, 7}),
        std::tuple(700, 12, std::vector<int>{7, 9, 12}), std::tuple(5, 3, std::vector<int>{3})}) {
    const Sample s = sample(static_cast<std::size_t>(points), depth, ends);
    const FrameStructure structure = s.structure();
    const std::vector<Short4> leaves = normals(s);
    for (const std::uint16_t step : std::initializer_list<std::uint16_t>{1, 700, 9000, 65535}) {
      TransformEncoder encoder(structure, AttributeKind::normals, leaves);
      TransformDecoder decoder(structure, AttributeKind::normals);
      std::vector<Bytes> layers;
      for (const int end : ends) {
        const auto second = static_cast<std::uint16_t>(step / 2 + 1);
        layers.push_back(encoder.encode_layer({step, second}));
        ASSERT_TRUE(decoder.decode_layer(layers.back(), end));
      }
      const auto expected = reference::decode_values(leaf_cells(s.svo), layers, ends, true);
      ASSERT_TRUE(expected) << expected.error().message;
      const std::span<const Short4> values = decoder.values(depth);
      ASSERT_EQ(values.size(), expected->nodes.size());
      for (std::size_t i = 0; i < values.size(); ++i) {
        const glm::ivec3 value(values[i].lanes[0], values[i].lanes[1], values[i].lanes[2]);
        ASSERT_EQ(value, expected->nodes[i]) << points << " points, step " << step;
      }
    }
  }
}

TEST(AttributeCoder, normals_come_back_nearly_and_unknown_ones_as_such) {
  const Sample s = sample(5000, 8, {7, 8});
  const FrameStructure structure = s.structure();
  const std::vector<Short4> leaves = normals(s);
  TransformEncoder encoder(structure, AttributeKind::normals, leaves);
  TransformDecoder decoder(structure, AttributeKind::normals);
  for (const int end : s.layer_ends) {
    const Bytes layer = encoder.encode_layer(
        layer_steps(normal_steps(80), s.svo.leaf_count(), s.svo.node_count(end)));
    ASSERT_TRUE(decoder.decode_layer(layer, end));
  }
  const std::span<const Short4> values = decoder.values(8);
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    const glm::vec3 normal = normal_from_value(leaves[i]), back = normal_from_value(values[i]);
    if (normal == glm::vec3(0.0f)) {
      EXPECT_EQ(back, normal);
    } else {
      EXPECT_GT(glm::dot(normal, back), 0.995f);
    }
  }
}

TEST(AttributeCoder, a_level_that_cannot_be_predicted_is_refused_if_it_is_said_to_be) {
  const Sample s = sample(300, 12, {12});
  ASSERT_FALSE(s.structure().level(11).predictable);
  Bytes bytes = encode(s, {2048, 2048})[0];
  const FrameStructure structure = s.structure();
  ASSERT_TRUE(TransformDecoder(structure, AttributeKind::colors).decode_layer(bytes, 12));
  for (const int bit : {0, 11, 12, 14}) {
    Bytes wrong = bytes;
    const std::uint8_t flag = static_cast<std::uint8_t>(1 << bit % 8);
    wrong[static_cast<std::size_t>(bit / 8)] |= flag;
    EXPECT_FALSE(TransformDecoder(structure, AttributeKind::colors).decode_layer(wrong, 12)) << bit;
  }
}

TEST(AttributeCoder, nodes_that_inherit_have_the_colour_of_their_ancestor) {
  const Sample s = sample(5000, 9, {7, 9});
  const std::vector<Bytes> layers = encode(s, {1024, 1024});
  const FrameStructure structure = s.structure();
  TransformDecoder decoder(structure, AttributeKind::colors);
  ASSERT_TRUE(decoder.decode_layer(layers[0], 7));
  const std::vector<glm::u16vec3> coarse = colors(decoder, 7);
  decoder.inherit(9);
  const std::vector<glm::u16vec3> fine = colors(decoder, 9);
  std::size_t at = 0;
  const auto check = [&](auto&& self, std::uint32_t node, int level, std::size_t ancestor) -> void {
    if (level == 9) {
      EXPECT_EQ(fine[at++], coarse[ancestor]);
      return;
    }
    const auto children = static_cast<std::uint32_t>(std::popcount(s.svo.masks[node]));
    for (std::uint32_t c = 0; c < children; ++c) {
      self(self, s.svo.first_child[node] + c, level + 1, ancestor);
    }
  };
  for (std::size_t i = 0; i < coarse.size(); ++i) {
    check(check, s.svo.level_begin[7] + static_cast<std::uint32_t>(i), 7, i);
  }
  EXPECT_EQ(at, fine.size());
}

TEST(AttributeCoder, a_cloud_of_one_colour_takes_almost_no_bytes) {
  Sample s = sample(20000, 9, {7, 9});
  for (glm::u16vec3& color : s.colors) color = glm::u16vec3(100, 7, 31) * std::uint16_t{257};
  const std::vector<Bytes> layers = encode(s, {1024, 1024});
  EXPECT_LT(total(layers), 60u + s.svo.internal_count() / 1000);
  for (const glm::u16vec3& color : decode(s, layers)) ASSERT_EQ(color, s.colors[0]);
}

TEST(AttributeCoder, a_tree_of_a_single_cell_keeps_its_colour) {
  PointCloud cloud;
  cloud.positions = {glm::vec3(0.3f)};
  const Sample s{build_svo(sort_points(cloud, Cube{}), 0), {{65535, 257, 0}}, {0}};
  EXPECT_EQ(decode(s, encode(s, {65535, 65535})), s.colors);
}

TEST(AttributeCoder, truncated_or_extended_bytes_are_an_error) {
  const Sample s = sample(300, 5, {5});
  const std::vector<Bytes> layers = encode(s, {2048, 2048});
  ASSERT_EQ(decode(s, layers).size(), s.colors.size());
  const FrameStructure structure = s.structure();
  for (std::size_t size = 0; size < layers[0].size(); ++size) {
    TransformDecoder decoder(structure, AttributeKind::colors);
    EXPECT_FALSE(decoder.decode_layer(ByteView(layers[0]).first(size), 5)) << size;
  }
  Bytes longer = layers[0];
  longer.insert(longer.end(), 12, 0x5a);
  EXPECT_FALSE(TransformDecoder(structure, AttributeKind::colors).decode_layer(longer, 5));
}

TEST(AttributeCoder, arbitrary_bytes_give_colours_or_an_error) {
  const Sample s = sample(200, 6, {6});
  const FrameStructure structure = s.structure();
  std::mt19937 random(3);
  for (int trial = 0; trial < 300; ++trial) {
    Bytes bytes(20 + random() % 300);
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
    bytes[0] &= 0x3e;
    bytes[1] &= trial % 2 == 0 ? 0x80 : 0;
    for (const AttributeKind kind : {AttributeKind::colors, AttributeKind::normals}) {
      TransformDecoder decoder(structure, kind);
      if (!decoder.decode_layer(bytes, 6)) decoder.inherit(6);
      EXPECT_EQ(decoder.values(6).size(), s.svo.leaf_count());
    }
  }
}

TEST(CoefficientSteps, halve_with_every_14_steps_of_quality) {
  EXPECT_EQ(color_steps(99).luma, 256);
  EXPECT_EQ(color_steps(85).luma, 512);
  EXPECT_EQ(color_steps(1).luma, 32768);
  for (int quality = 2; quality <= 99; ++quality) {
    EXPECT_LT(color_steps(quality).luma, color_steps(quality - 1).luma);
    EXPECT_GE(color_steps(quality).chroma, color_steps(quality).luma);
    EXPECT_EQ(normal_steps(quality).chroma, 2 * normal_steps(quality).luma);
    EXPECT_EQ(normal_steps(quality).luma, color_steps(quality).luma * 15 / 16);
  }
}

}  // namespace
}  // namespace pointreel::attribute_coder_test
