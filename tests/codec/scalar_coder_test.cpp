#include "codec/octree/scalar_coder.h"

#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codec/core/scalar_fields.h"
#include "codec/octree/frame_header.h"
#include "pointreel/codec.h"

namespace pointreel::scalar_coder_test {
namespace {

using testing::HasSubstr;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kMost = std::numeric_limits<float>::max();

/// Points on a lattice of `side` cells, each of them the only one of its leaf.
struct Patch {
  PointCloud cloud;
  Cube cube;
  OctreeOptions options;
};

Patch patch(int side) {
  Patch made;
  int depth = 0;
  while (1 << depth < side) ++depth;
  made.cube = {glm::dvec3(-0.5), static_cast<double>(1 << depth)};
  made.options.depth = DepthRule::fixed(depth);
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) made.cloud.positions.emplace_back(x, y, (x + y) / 2);
  }
  return made;
}

/// Adds a field whose value is `of` its point's position.
template <class Of>
void add(Patch& to, const std::string& name, Of of) {
  ScalarField field{name, {}};
  for (const glm::vec3& p : to.cloud.positions) field.values.push_back(of(p));
  to.cloud.scalars.push_back(std::move(field));
}

std::vector<ScalarField> decoded(const EncodedFrame& frame, const DecodeLimits& limits = {}) {
  return decode_octree(layer_views(frame.layers), limits).value().cloud.scalars;
}

EncodedFrame encoded(const Patch& of) {
  return encode_octree(of.cloud, of.cube, of.options).value();
}

/// Encodes and decodes. The values come back in the order of the points.
std::vector<ScalarField> round_trip(const Patch& of) {
  const EncodedFrame frame = encoded(of);
  const DecodedFrame whole = decode_octree(layer_views(frame.layers)).value();
  std::map<std::vector<int>, std::size_t> leaves;
  const auto key = [](const glm::dvec3& p) {
    return std::vector<int>{static_cast<int>(std::lround(p.x)), static_cast<int>(std::lround(p.y)),
                            static_cast<int>(std::lround(p.z))};
  };
  for (std::size_t i = 0; i < whole.cloud.size(); ++i) leaves[key(whole.cloud.world(i))] = i;
  std::vector<ScalarField> fields;
  for (const ScalarField& field : whole.cloud.scalars) {
    ScalarField& ordered = fields.emplace_back(ScalarField{field.name, {}});
    for (std::size_t i = 0; i < of.cloud.size(); ++i)
      ordered.values.push_back(field.values[leaves.at(key(of.cloud.world(i)))]);
  }
  return fields;
}

double largest_error(const ScalarField& a, const ScalarField& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.values.size(); ++i)
    largest = std::max(largest, std::abs(double{a.values[i]} - b.values[i]));
  return largest;
}

TEST(Scalars, keep_smooth_values_to_half_a_step_of_their_range) {
  Patch made = patch(60);
  add(made, "height", [](const glm::vec3& p) { return 3.0f + std::sin(p.x / 9) * p.y; });
  const auto fields = round_trip(made);
  ASSERT_EQ(fields.size(), 1u);
  EXPECT_EQ(fields[0].name, "height");
  const ScalarSummary summary = summary_of(made.cloud.scalars[0].values);
  EXPECT_LE(largest_error(fields[0], made.cloud.scalars[0]), summary.range() / 255 * 0.501);
}

TEST(Scalars, keep_labels_and_other_small_whole_numbers_exactly) {
  Patch made = patch(60);
  std::mt19937 random(1);
  add(made, "class", [&](const glm::vec3&) { return std::vector{2.0f, 6.0f, 9.0f}[random() % 3]; });
  add(made, "byte", [&](const glm::vec3&) { return static_cast<float>(random() % 256); });
  add(made, "signed", [&](const glm::vec3& p) { return -100.0f + p.x; });
  EXPECT_EQ(round_trip(made), made.cloud.scalars);
}

TEST(Scalars, keep_multiples_of_a_stated_step_exactly) {
  Patch made = patch(60);
  add(made, "wide", [](const glm::vec3& p) { return -7000.0f + 200 * p.x + p.y; });
  add(made, "half", [](const glm::vec3& p) { return 0.5f * p.x - 3.5f; });
  made.options.scalar_steps = {{"wide", 1.0}, {"half", 0.5}};
  EXPECT_EQ(round_trip(made), made.cloud.scalars);
}

TEST(Scalars, keep_constants_exactly) {
  Patch made = patch(20);
  for (const float value : {0.0f, -0.1f, 1e30f, kMost, -kMost, 1e-42f})
    add(made, "constant " + std::to_string(made.cloud.scalars.size()),
        [&](const glm::vec3&) { return value; });
  EXPECT_EQ(round_trip(made), made.cloud.scalars);
}

TEST(Scalars, say_where_a_value_is_unknown) {
  Patch made = patch(30);
  add(made, "patchy", [](const glm::vec3& p) { return p.x > 20 ? kNan : p.x; });
  add(made, "first", [](const glm::vec3& p) { return p.x < 1 ? kNan : 5.0f; });
  add(made, "nothing", [](const glm::vec3&) { return kNan; });
  const auto fields = round_trip(made);
  ASSERT_EQ(fields.size(), 2u) << "a field without a known value is left out";
  for (std::size_t i = 0; i < made.cloud.size(); ++i) {
    const float x = made.cloud.positions[i].x;
    EXPECT_EQ(std::isnan(fields[0].values[i]), x > 20);
    if (x <= 20) {
      EXPECT_EQ(fields[0].values[i], x);
    }
    EXPECT_EQ(std::isnan(fields[1].values[i]), x < 1);
  }
}

TEST(Scalars, survive_huge_ranges) {
  Patch made = patch(20);
  add(made, "huge", [](const glm::vec3& p) { return p.x < 10 ? -kMost : kMost; });
  add(made, "outlier", [](const glm::vec3& p) { return p == glm::vec3(0) ? 1e30f : p.x / 19; });
  const auto fields = round_trip(made);
  for (const float value : fields[0].values) EXPECT_TRUE(std::isfinite(value));
  EXPECT_LT(largest_error(fields[0], made.cloud.scalars[0]), 1e-6 * kMost);
  EXPECT_GT(fields[1].values[0], 0.99e30f);
}

TEST(Scalars, are_not_made_coarse_by_a_few_values_far_away) {
  Patch made = patch(60);
  add(made, "intensity", [](const glm::vec3& p) { return p.x + p.y == 0 ? 6000.0f : p.x + 0.1f; });
  const auto fields = round_trip(made);
  for (std::size_t i = 1; i < made.cloud.size(); ++i)
    EXPECT_NEAR(fields[0].values[i], made.cloud.scalars[0].values[i], 0.24);
}

TEST(Scalars, of_a_leaf_are_the_mean_of_its_points_or_the_label_of_most) {
  PointCloud cloud;
  cloud.positions = {{0, 0, 0}, {0.1f, 0, 0}, {0, 0.1f, 0}, {3, 3, 3}};
  cloud.scalars = {
      {"class", {1, 9, 9, 4}}, {"heat", {0, 0.6f, 0.6f, 40.8f}}, {"some", {kNan, 2, kNan, 7}}};
  OctreeOptions options;
  options.depth = DepthRule::fixed(2);
  options.scalar_steps = {{"heat", 0.2}};
  const EncodedFrame frame = encode_octree(cloud, {glm::dvec3(0), 4.0}, options).value();
  const auto fields = decoded(frame);
  EXPECT_EQ(fields[0].values, (std::vector<float>{9, 4}));
  EXPECT_NEAR(fields[1].values[0], 0.4, 1e-6);
  EXPECT_NEAR(fields[1].values[1], 40.8, 1e-4);
  EXPECT_EQ(fields[2].values, (std::vector<float>{2, 7}));
}

TEST(Scalars, are_the_same_with_all_codings_of_geometry_and_eight_at_a_time) {
  Patch made = patch(40);
  for (int i = 0; i < 8; ++i)
    add(made, "field " + std::to_string(i),
        [&](const glm::vec3& p) { return p.x * static_cast<float>(i) + p.y; });
  made.options.scalar_steps = {};
  const auto with = [&](Entropy entropy) {
    made.options.entropy = entropy;
    return round_trip(made);
  };
  const auto fields = with(Entropy::context);
  ASSERT_EQ(fields.size(), 8u);
  EXPECT_EQ(with(Entropy::none), fields);
  EXPECT_EQ(with(Entropy::zstd), fields);
}

TEST(Scalars, depend_neither_on_the_order_of_the_points_nor_on_threads) {
  Patch made = patch(40);
  add(made, "heat", [](const glm::vec3& p) { return std::sqrt(p.x + 40 * p.y); });
  add(made, "class", [](const glm::vec3& p) { return p.x < p.y ? 1.0f : 2.0f; });
  const EncodedFrame frame = encoded(made);
  std::vector<std::size_t> order(made.cloud.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::shuffle(order.begin(), order.end(), std::mt19937(3));
  PointCloud shuffled = made.cloud;
  for (std::size_t i = 0; i < order.size(); ++i) {
    shuffled.positions[i] = made.cloud.positions[order[i]];
    for (std::size_t f = 0; f < 2; ++f)
      shuffled.scalars[f].values[i] = made.cloud.scalars[f].values[order[i]];
  }
  const Executor backwards = [](int count, const std::function<void(int)>& body) {
    while (count-- > 0) body(count);
  };
  const EncodedFrame again =
      encode_octree(shuffled, made.cube, made.options, true, true, backwards).value();
  EXPECT_EQ(again.layers, frame.layers);
}

TEST(Scalars, cost_nothing_where_there_are_none) {
  Patch made = patch(20);
  const EncodedFrame without = encoded(made);
  EXPECT_FALSE(without.has_scalars);
  add(made, "x", [](const glm::vec3& p) { return p.x; });
  EncodedFrame with = encoded(made);
  EXPECT_TRUE(with.has_scalars);
  EXPECT_EQ(with.scalar_bytes(), with.size() - without.size());
  with.layers.pop_back();
  EXPECT_EQ(with.layers, without.layers) << "decoders that know no scalar fields see this";
  made.options.scalars = false;
  EXPECT_EQ(encoded(made).layers, without.layers);
}

TEST(Scalars, are_decoded_only_if_they_are_wanted_and_all_layers_are_there) {
  Patch made = patch(200);  // two layers
  add(made, "x", [](const glm::vec3& p) { return p.x; });
  add(made, "y", [](const glm::vec3& p) { return p.y; });
  const EncodedFrame frame = encoded(made);
  ASSERT_EQ(frame.layers.size(), 3u);
  DecodeLimits limits;
  limits.scalar = "y";
  ASSERT_EQ(decoded(frame, limits).size(), 1u);
  EXPECT_EQ(decoded(frame, limits)[0].name, "y");
  limits.scalar = "z";
  EXPECT_TRUE(decoded(frame, limits).empty());
  limits = {};
  limits.scalars = false;
  EXPECT_TRUE(decoded(frame, limits).empty());
  limits = {};
  limits.leaves = false;
  const DecodedFrame tree = decode_octree(layer_views(frame.layers), limits).value();
  ASSERT_EQ(tree.scalars.size(), 2u);
  EXPECT_EQ(tree.scalars[0].values.size(), tree.svo->leaf_count());
  limits.depth = 7;
  EXPECT_TRUE(decode_octree(layer_views(frame.layers), limits).value().scalars.empty());
  std::vector<Chunks<ByteView>> base = layer_views(frame.layers);
  base.resize(1);
  EXPECT_FALSE(decode_octree(base).value().cloud.has_scalars());
}

TEST(Scalars, must_have_good_names_and_as_many_values_as_there_are_points) {
  const auto error = [](std::vector<ScalarField> fields) {
    Patch made = patch(2);
    made.cloud.scalars = std::move(fields);
    const auto refused = encode_octree(made.cloud, made.cube, made.options);
    EXPECT_EQ(refused.error().code, ErrorCode::argument);
    return refused.error().message;
  };
  EXPECT_THAT(error({{"a", {1, 2, 3}}}), HasSubstr("3 values for 4 points"));
  EXPECT_THAT(error({{"a\n", {1, 2, 3, 4}}}), HasSubstr("name"));
  EXPECT_THAT(error({{"a", {1, 2, 3, 4}}, {"a", {1, 2, 3, 4}}}), HasSubstr("two"));
  EXPECT_THAT(error(std::vector<ScalarField>(9)), HasSubstr("9 scalar fields"));
  Patch made = patch(2);
  made.options.scalar_steps = {{"a", 0.0}};
  EXPECT_EQ(encode_octree(made.cloud, made.cube, made.options).error().code, ErrorCode::argument);
}

/// The payload of the frame's chunk of scalar fields.
Bytes payload_of(const EncodedFrame& frame) {
  const Bytes& chunk = frame.layers.back().geometry;
  return {chunk.begin() + kChunkHeaderSize, chunk.end()};
}

/// The frame with another payload, whose checksum is right.
std::string error_with(EncodedFrame frame, const Bytes& payload) {
  const auto tag = read_frame_header(frame.layers.front().geometry)->tag;
  const auto layer = static_cast<std::uint8_t>(frame.layers.size() - 1);
  frame.layers.back().geometry.clear();
  write_chunk({ChunkKind::scalars, Entropy::none, layer, static_cast<std::uint8_t>(frame.depth),
               static_cast<std::uint32_t>(payload.size())},
              tag, payload, frame.layers.back().geometry);
  const auto refused = decode_octree(layer_views(frame.layers));
  return refused ? "" : refused.error().message;
}

TEST(Scalars, that_are_damaged_are_refused) {
  Patch made = patch(12);
  add(made, "abc", [](const glm::vec3& p) { return p.x; });
  add(made, "abd", [](const glm::vec3& p) { return p.y; });
  const EncodedFrame frame = encoded(made);
  const Bytes good = payload_of(frame);
  ASSERT_EQ(error_with(frame, good), "");
  const auto changed = [&](std::size_t at, std::uint8_t to) {
    Bytes bytes = good;
    bytes.at(at) = to;
    return error_with(frame, bytes);
  };
  EXPECT_THAT(changed(0, 0), HasSubstr("0 fields"));
  EXPECT_THAT(changed(0, 9), HasSubstr("9 fields"));
  EXPECT_THAT(changed(1, 4), HasSubstr("out of range"));                 // flags
  EXPECT_THAT(changed(1 + 1 + 8 + 7, 0xff), HasSubstr("out of range"));  // a step below 0
  EXPECT_THAT(changed(1 + 1 + 16, 0), HasSubstr("scalar fields"));       // no name
  EXPECT_THAT(changed(1 + 18 + 2, 'd'), HasSubstr("same name"));
  for (std::size_t size = 0; size < good.size(); ++size)
    EXPECT_NE(
        error_with(frame, Bytes(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size))),
        "");
  Bytes longer = good;
  longer.push_back(0);
  EXPECT_THAT(error_with(frame, longer), HasSubstr("follow"));
  EncodedFrame other = frame;
  other.layers.back().geometry.back() ^= 1;
  EXPECT_THAT(decode_octree(layer_views(other.layers)).error().message, HasSubstr("checksum"));
}

TEST(Scalars, take_no_more_memory_than_allowed) {
  Patch made = patch(100);
  for (int i = 0; i < 8; ++i) add(made, std::to_string(i), [&](const glm::vec3& p) { return p.x; });
  const EncodedFrame frame = encoded(made);
  DecodeLimits limits;
  limits.max_memory = 1'200'000;
  EXPECT_EQ(decode_octree(layer_views(frame.layers), limits).error().code, ErrorCode::limit);
  limits.scalars = false;
  EXPECT_TRUE(decode_octree(layer_views(frame.layers), limits));
}

TEST(ScalarRanges, cover_all_frames) {
  std::vector<ScalarRange> all = {{"a", 1, 2, true}};
  cover(all, {{"a", -1, 0.5, false}, {"b", 3, 4, true}});
  EXPECT_EQ(all, (std::vector<ScalarRange>{{"a", -1, 2, false}, {"b", 3, 4, true}}));
  for (int i = 0; i < 20; ++i) cover(all, {{std::to_string(i), 0, 1, false}});
  EXPECT_EQ(all.size(), kMaxScalars);
}

}  // namespace
}  // namespace pointreel::scalar_coder_test
