#include "tests/reference/color_decoder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <optional>
#include <string>

#include "common/base/byte_io.h"
#include "common/base/try.h"
#include "common/octree/morton.h"

namespace pointreel::reference {
namespace {

using Components = std::array<std::int64_t, 3>;

struct Node {
  std::int64_t weight = 0;
  Components value{};
  std::int64_t activity = 0;
};

/// The nodes of a level, by Morton key.
using Level = std::map<std::uint64_t, Node>;

class RangeDecoder {
 public:
  RangeDecoder(ByteView bytes, std::size_t begin) : bytes_(bytes), next_(begin) { shift(8); }

  bool bit(std::uint64_t probability) {
    const std::uint64_t one = (range_ >> 16) * probability;
    const bool result = value_ < one;
    if (result) {
      range_ = one;
    } else {
      value_ -= one;
      range_ -= one;
    }
    if (range_ < std::uint64_t{1} << 32) {
      range_ <<= 32;
      shift(4);
    }
    return result;
  }

  /// True if the bytes end where the bits do, apart from zeros.
  bool complete() const {
    const std::size_t end = next_ - 4;
    return end <= bytes_.size() && std::all_of(bytes_.begin() + static_cast<std::ptrdiff_t>(end),
                                               bytes_.end(), [](auto byte) { return byte == 0; });
  }

 private:
  void shift(int count) {
    for (; count > 0; --count, ++next_) {
      value_ = value_ << 8 | (next_ < bytes_.size() ? bytes_[next_] : 0u);
    }
  }

  ByteView bytes_;
  std::size_t next_;
  std::uint64_t value_ = 0, range_ = ~std::uint64_t{0};
};

class AdaptiveBits {
 public:
  bool decode(RangeDecoder& range, const std::string& context) {
    Learnt& known = learnt_[context];
    ++known.decisions;
    int digits = 0;
    while (digits < 7 && known.decisions >> digits != 0) ++digits;
    const bool bit = range.bit((known.f + known.s) >> 1);
    const auto follow = [bit](std::uint32_t& estimate, int shift) {
      if (bit) {
        estimate = 65535 - ((65535 - estimate) - ((65535 - estimate) >> shift));
      } else {
        estimate -= estimate >> shift;
      }
    };
    follow(known.f, std::min(digits, 3));
    follow(known.s, digits);
    return bit;
  }

 private:
  struct Learnt {
    std::uint32_t f = 32768, s = 32768;
    std::uint64_t decisions = 0;
  };
  std::map<std::string, Learnt> learnt_;
};

std::string context(const char* name, std::initializer_list<std::int64_t> numbers) {
  std::string all = name;
  for (const std::int64_t number : numbers) all += " " + std::to_string(number);
  return all;
}

struct Pair {
  int lower, higher;  ///< octants
  std::int64_t w0, w1;
};

/// The pairs of a node whose children have these weights, 0 for missing ones.
std::vector<Pair> pairs_of(std::array<std::int64_t, 8> weight, std::array<int, 8>& moved_to) {
  std::vector<Pair> pairs;
  std::array<int, 8> holder{};  // the child that a value came from
  for (int octant = 0; octant < 8; ++octant) holder[static_cast<std::size_t>(octant)] = octant;
  for (const int axis : {1, 2, 4}) {
    for (int octant = 0; octant < 8; ++octant) {
      if ((octant & axis) != 0) continue;
      auto& lower = weight[static_cast<std::size_t>(octant)];
      auto& higher = weight[static_cast<std::size_t>(octant | axis)];
      auto& lower_holder = holder[static_cast<std::size_t>(octant)];
      const int higher_holder = holder[static_cast<std::size_t>(octant | axis)];
      if (lower > 0 && higher > 0) pairs.push_back({lower_holder, higher_holder, lower, higher});
      if (lower == 0) lower_holder = higher_holder;
      lower += higher;
      higher = 0;
    }
  }
  moved_to = holder;
  return pairs;
}

std::int64_t ratio_of(const Pair& pair) {
  return ((pair.w1 << 14) + (pair.w0 + pair.w1) / 2) / (pair.w0 + pair.w1);
}

std::int64_t step_of(const Pair& pair, std::int64_t layer_step) {
  const auto squared = static_cast<std::uint64_t>(pair.w0 + pair.w1) << 34;
  const std::uint64_t target = squared / static_cast<std::uint64_t>(pair.w0 * pair.w1);
  auto root = static_cast<std::uint64_t>(std::sqrt(static_cast<long double>(target)));
  while (root * root > target) --root;
  while ((root + 1) * (root + 1) <= target) ++root;
  const std::int64_t step = layer_step * static_cast<std::int64_t>(root) >> 11;
  return std::clamp<std::int64_t>(step, 1 << 9, 1 << 24);
}

class Decoder {
 public:
  explicit Decoder(const std::vector<glm::uvec3>& leaves, int depth)
      : levels_(static_cast<std::size_t>(depth) + 1) {
    for (const glm::uvec3& leaf : leaves) {
      for (int level = 0; level <= depth; ++level) {
        levels_[static_cast<std::size_t>(level)][morton_encode(leaf >> unsigned(depth - level))];
      }
    }
  }

  Result<void> layer(ByteView bytes, int first_level, int last_level, bool base) {
    ByteReader reader(bytes);
    const unsigned flags = reader.get<std::uint8_t>();
    if (flags > 3) return fail("flags");
    predicts_ = (flags & 1) != 0;
    if (base) exact_ = (flags & 2) != 0;
    if (exact_ != ((flags & 2) != 0)) return fail("layers of both kinds");
    const std::int64_t luma = reader.get<std::uint16_t>(), chroma = reader.get<std::uint16_t>();
    steps_ = {luma, chroma, chroma};
    if (luma == 0 || chroma == 0) return fail("steps");
    if (base && !levels_[0].empty()) {
      for (std::int64_t& v : levels_[0].begin()->second.value) v = reader.get<std::int16_t>();
    }
    if (!reader.ok()) return fail("cut short");
    RangeDecoder range(bytes, bytes.size() - reader.rest().size());
    for (auto& [key, node] : levels_[static_cast<std::size_t>(last_level)]) node.weight = 1;
    for (int level = last_level; level-- > first_level;) {
      Level& above = levels_[static_cast<std::size_t>(level)];
      for (auto& [key, node] : above) node.weight = 0;
      for (const auto& [key, node] : levels_[static_cast<std::size_t>(level) + 1]) {
        std::int64_t& weight = above[key >> 3].weight;
        weight += node.weight;
      }
      for (auto& [key, node] : above) {
        node.weight = std::min<std::int64_t>(node.weight, 1 << 26);
      }
    }
    last_activity_ = 0;
    for (int level = first_level; level < last_level; ++level) {
      for (auto& [key, node] : levels_[static_cast<std::size_t>(level)]) {
        code_node(range, level, key, node);
      }
    }
    return range.complete() ? Result<void>{} : fail("coded bytes end elsewhere");
  }

  Values values() const {
    Values values;
    values.exact = exact_;
    for (const auto& [key, node] : levels_.back()) {
      values.nodes.emplace_back(node.value[0], node.value[1], node.value[2]);
    }
    return values;
  }

 private:
  const Node* neighbor(int level, std::uint64_t key, const glm::ivec3& step) const {
    const glm::ivec3 cell = glm::ivec3(morton_decode(key)) + step;
    for (int axis = 0; axis < 3; ++axis) {
      if (cell[axis] < 0 || cell[axis] >= 1 << level) return nullptr;
    }
    const Level& nodes = levels_[static_cast<std::size_t>(level)];
    const auto found = nodes.find(morton_encode(glm::uvec3(cell)));
    return found == nodes.end() ? nullptr : &found->second;
  }

  void code_node(RangeDecoder& range, int level, std::uint64_t key, Node& node) {
    std::array<Node*, 8> child{};
    std::array<std::int64_t, 8> weight{};
    int children = 0;
    for (std::uint64_t octant = 0; octant < 8; ++octant) {
      Level& below = levels_[static_cast<std::size_t>(level) + 1];
      const auto found = below.find(key << 3 | octant);
      if (found == below.end()) continue;
      child[octant] = &found->second;
      weight[octant] = found->second.weight;
      ++children;
    }
    if (children == 1) {
      for (Node* only : child) {
        if (only == nullptr) continue;
        only->value = node.value;
        only->activity = node.activity;
      }
      return;
    }

    // Compute the expected values.
    const bool predicts = predicts_ && level > 0;
    std::array<Components, 8> expected{};
    std::int64_t near_activity = predicts ? 0 : last_activity_, near_weight = predicts ? 0 : 1;
    std::int64_t least = node.value[0], most = node.value[0];
    for (int octant = 0; octant < 8 && predicts; ++octant) {
      if (child[static_cast<std::size_t>(octant)] == nullptr) continue;
      const int x = (octant & 1) != 0 ? 1 : -1, y = (octant & 2) != 0 ? 1 : -1,
                z = (octant & 4) != 0 ? 1 : -1;
      Components sum{};
      std::int64_t weights = 0, activities = 0;
      const auto add = [&](const Node* from, std::int64_t w) {
        if (from == nullptr) return;
        for (std::size_t k = 0; k < 3; ++k) sum[k] += w * from->value[k];
        weights += w;
        activities += w * from->activity;
      };
      add(&node, 18);
      for (const glm::ivec3& face : {glm::ivec3(x, 0, 0), glm::ivec3(0, y, 0), glm::ivec3(0, 0, z)})
        add(neighbor(level, key, face), 8);
      for (const glm::ivec3& edge : {glm::ivec3(x, y, 0), glm::ivec3(0, y, z), glm::ivec3(x, 0, z)})
        add(neighbor(level, key, edge), 3);
      Components& e = expected[static_cast<std::size_t>(octant)];
      for (std::size_t k = 0; k < 3; ++k) e[k] = (sum[k] * (65536 / weights) + (1 << 15)) >> 16;
      least = std::min(least, e[0]);
      most = std::max(most, e[0]);
      near_activity += activities;
      near_weight += weights;
    }

    // Determine the contexts.
    int gradient = 0;
    if (predicts) {
      for (const int part : {1, 2, 4, 8}) gradient += 8 * (most - least) / part >= steps_[0] / 4;
    }
    const int activity = near_activity == 0                    ? 0
                         : 2 * near_activity < near_weight     ? 1
                         : near_activity < near_weight         ? 2
                         : 2 * near_activity < 5 * near_weight ? 3
                         : near_activity < 6 * near_weight     ? 4
                         : near_activity < 12 * near_weight    ? 5
                                                               : 6;
    std::array<int, 8> moved_to{};
    const std::vector<Pair> pairs = pairs_of(weight, moved_to);
    const int size = pairs.size() == 1 ? 0 : pairs.size() == 2 ? 1 : pairs.size() <= 4 ? 2 : 3;

    // Compute the differences of the expected values.
    std::vector<Components> expected_difference(pairs.size());
    std::array<Components, 8> e = expected;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      Components& lower = e[static_cast<std::size_t>(pairs[i].lower)];
      const Components& higher = e[static_cast<std::size_t>(pairs[i].higher)];
      for (std::size_t k = 0; k < 3; ++k) {
        expected_difference[i][k] = higher[k] - lower[k];
        lower[k] += (expected_difference[i][k] * ratio_of(pairs[i]) + (1 << 13)) >> 14;
      }
    }

    // Decode the coefficients.
    std::vector<Components> q(pairs.size());
    std::int64_t sum = 0;
    if (bits_.decode(range, context("node", {gradient, activity, size}))) {
      int nonzero = 0;
      for (std::size_t i = pairs.size(); i-- > 0;) {
        const auto place =
            static_cast<std::int64_t>(std::min<std::size_t>(pairs.size() - 1 - i, 2));
        const std::string any =
            context("triple", {gradient, std::min(nonzero, 2), activity, place});
        q[i] = triple(range, any, activity, expected_difference[i], i == 0 && nonzero == 0);
        nonzero += q[i] != Components{};
        sum += 2 * std::abs(q[i][0]) + std::abs(q[i][1]) + std::abs(q[i][2]);
      }
    }
    const auto count = static_cast<std::int64_t>(pairs.size());
    node.activity = last_activity_ = std::min<std::int64_t>(127, 4 * sum / count);

    // Undo the transform.
    const auto top = static_cast<std::size_t>(moved_to[0]);
    for (std::size_t k = 0; k < 3; ++k) {
      std::array<std::int64_t, 8> v{};
      v[top] = exact_ ? node.value[k] : node.value[k] - e[top][k];
      for (std::size_t i = pairs.size(); i-- > 0;) {
        const std::int64_t magnitude = std::min<std::int64_t>(
            (std::abs(q[i][k]) * step_of(pairs[i], steps_[k]) + (1 << 7)) >> 8, 1 << 16);
        const std::int64_t d =
            exact_ ? std::clamp<std::int64_t>(q[i][k] + expected_difference[i][k], -65536, 65536)
            : q[i][k] < 0 ? -magnitude
                          : magnitude;
        auto& lower = v[static_cast<std::size_t>(pairs[i].lower)];
        lower -= (d * ratio_of(pairs[i]) + (1 << 13)) >> 14;
        v[static_cast<std::size_t>(pairs[i].higher)] = lower + d;
      }
      for (std::size_t octant = 0; octant < 8; ++octant) {
        if (child[octant] == nullptr) continue;
        const std::int64_t add = exact_ ? 0 : expected[octant][k];
        child[octant]->value[k] = std::clamp<std::int64_t>(v[octant] + add, -16384, 16383);
        child[octant]->activity = node.activity;
      }
    }
  }

  Components triple(RangeDecoder& range, const std::string& any, int activity,
                    const Components& expected_difference, bool certain) {
    Components q{};
    if (!certain && !bits_.decode(range, any)) return q;
    int m = 0, s = 4;
    for (int k = 0; k < 3; ++k) {
      if (!(k == 2 && m == 0) && !bits_.decode(range, context("component", {k, m, activity}))) {
        continue;
      }
      std::int64_t magnitude = 1;
      if (bits_.decode(range, context("above_one", {k, activity}))) {
        magnitude = 2;
        if (bits_.decode(range, context("above_two", {k, activity}))) {
          int digits = 1;
          while (digits < 16 && bits_.decode(range, context("length", {k, digits}))) ++digits;
          std::int64_t rest = 1;
          for (int i = 1; i < digits; ++i) {
            const bool digit = i == 1 ? bits_.decode(range, context("second_digit", {k, digits}))
                                      : range.bit(32768);
            rest = 2 * rest + digit;
          }
          magnitude = rest + 2;
        }
      }
      const std::int64_t expected = expected_difference[static_cast<std::size_t>(k)];
      const int e = expected > 0 ? 1 : expected < 0 ? 2 : 0;
      const bool negative = bits_.decode(range, context("sign", {k, s, e}));
      q[static_cast<std::size_t>(k)] = negative ? -magnitude : magnitude;
      ++m;
      if (k == 0) s += negative ? 3 : -3;
      if (k == 1) s += negative ? 1 : -1;
    }
    return q;
  }

  std::vector<Level> levels_;
  AdaptiveBits bits_;
  bool predicts_ = false, exact_ = false;
  std::array<std::int64_t, 3> steps_{};
  std::int64_t last_activity_ = 0;
};

}  // namespace

Result<Values> decode_values(const std::vector<glm::uvec3>& leaves,
                             const std::vector<Bytes>& layers, const std::vector<int>& layer_ends) {
  Decoder decoder(leaves, layer_ends[layers.size() - 1]);
  for (std::size_t i = 0; i < layers.size(); ++i) {
    TRY(decoder.layer(layers[i], i == 0 ? 0 : layer_ends[i - 1], layer_ends[i], i == 0));
  }
  return decoder.values();
}

glm::u16vec3 color_of_value(const glm::ivec3& value, int bits) {
  const std::int64_t y = value.x, b = value.y, r = value.z;
  const auto component = [bits](std::int64_t c) {
    if (bits == 16) {
      const std::int64_t v = ((c >> 8) * 257 + (1 << 11)) >> 12;
      return static_cast<std::uint16_t>(std::clamp<std::int64_t>(v, 0, 65535));
    }
    return static_cast<std::uint16_t>(257 *
                                      std::clamp<std::int64_t>((c + (1 << 19)) >> 20, 0, 255));
  };
  return {component(16384 * y + 25802 * r), component(16384 * y - 3069 * b - 7670 * r),
          component(16384 * y + 30402 * b)};
}

glm::u16vec3 color_of_exact_value(const glm::ivec3& value) {
  const int t = value.x - (value.y >> 1), g = value.y + t, b = t - (value.z >> 1);
  return glm::u16vec3(glm::clamp(glm::ivec3(b + value.z, g, b), 0, 255) * 257);
}

std::vector<glm::u16vec3> decode_colors(const std::vector<glm::uvec3>& leaves,
                                        const std::vector<Bytes>& layers,
                                        const std::vector<int>& layer_ends) {
  std::vector<glm::u16vec3> colors;
  const auto values = decode_values(leaves, layers, layer_ends);
  if (!values) return colors;
  for (const glm::ivec3& value : values->nodes) {
    colors.push_back(values->exact ? color_of_exact_value(value) : color_of_value(value, 8));
  }
  return colors;
}

}  // namespace pointreel::reference
