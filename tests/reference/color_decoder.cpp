#include "tests/reference/color_decoder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <string>

#include "codec/core/morton.h"
#include "common/base/byte_io.h"
#include "common/base/try.h"
#include "tests/reference/symbol_reader.h"

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

/// The alphabets of a frame, by their names.
class Alphabets {
 public:
  /// A new one has 8 symbols, of which the first `used` are used; or, if that is 0, its frequencies
  /// halve from symbol to symbol.
  Alphabet& operator()(const char* name, int used, std::initializer_list<std::int64_t> numbers) {
    std::string key = name;
    for (const std::int64_t number : numbers) key.append(" ").append(std::to_string(number));
    const auto found = all_.find(key);
    if (found != all_.end()) return found->second;
    const Alphabet made = used == 0 ? Alphabet({128, 64, 32, 16, 8, 4, 2, 2}) : Alphabet(8, used);
    return all_.emplace(key, made).first->second;
  }

 private:
  std::map<std::string, Alphabet> all_;
};

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

std::int64_t divided(std::int64_t a, std::int64_t b) {
  return a >= 0 ? a / b : -((-a + b - 1) / b);
}

class Decoder {
 public:
  Decoder(const std::vector<glm::uvec3>& leaves, int depth, bool normals)
      : normals_(normals), levels_(static_cast<std::size_t>(depth) + 1) {
    for (const glm::uvec3& leaf : leaves) {
      for (int level = 0; level <= depth; ++level) {
        levels_[static_cast<std::size_t>(level)][morton_encode(leaf >> unsigned(depth - level))];
      }
    }
    can_be_predicted_.push_back(false);
    for (int level = 1; level < depth; ++level) {
      const std::uint64_t nodes = levels_[static_cast<std::size_t>(level)].size();
      glm::uvec3 least(~0u), most(0u);
      for (const glm::uvec3& leaf : leaves) {
        least = glm::min(least, leaf >> unsigned(depth - level));
        most = glm::max(most, leaf >> unsigned(depth - level));
      }
      const std::uint64_t columns = most.x - least.x + 3, rows = most.y - least.y + 3;
      can_be_predicted_.push_back((level == 1 || can_be_predicted_.back()) &&
                                  columns * rows <= std::max<std::uint64_t>(65536, 2 * nodes) &&
                                  std::max(columns, rows) <= 32770);
    }
  }

  Result<void> layer(ByteView bytes, int first_level, int last_level, bool base) {
    ByteReader fields(bytes);
    const unsigned flags = fields.get<std::uint16_t>();
    if (base) exact_ = (flags & 0x8000) != 0;
    if (exact_ != ((flags & 0x8000) != 0)) return fail("layers of both kinds");
    if (exact_ && normals_) return fail("exact normals");
    const std::int64_t first = fields.get<std::uint16_t>(), second = fields.get<std::uint16_t>();
    steps_ = {first, normals_ ? first : second, second};
    if (first == 0 || second == 0) return fail("steps");
    if (base && !levels_[0].empty()) {
      for (std::int64_t& v : levels_[0].begin()->second.value) {
        v = std::clamp<std::int64_t>(fields.get<std::int16_t>(), -16384, 16383);
      }
    }
    if (!fields.ok()) return fail("cut short");
    for (int bit = 0; bit < 15; ++bit) {
      const int level = first_level + bit;
      if ((flags >> bit & 1) != 0 &&
          (level >= last_level || !can_be_predicted_[static_cast<std::size_t>(level)])) {
        return fail("predicted");
      }
    }
    for (auto& [key, node] : levels_[static_cast<std::size_t>(last_level)]) node.weight = 1;
    for (int level = last_level; level-- > first_level;) {
      Level& above = levels_[static_cast<std::size_t>(level)];
      for (auto& [key, node] : above) node.weight = 0;
      for (const auto& [key, node] : levels_[static_cast<std::size_t>(level) + 1]) {
        above[key >> 3].weight += node.weight;
      }
      for (auto& [key, node] : above) {
        node.weight = std::min<std::int64_t>(node.weight, 1 << 26);
      }
    }
    SymbolReader reader(fields.rest());
    for (int level = first_level; level < last_level; ++level) {
      predicts_ = (flags >> (level - first_level) & 1) != 0;
      recent_ = 0;
      for (const auto& [key, node] : levels_[static_cast<std::size_t>(level)]) {
        code_node(reader, level, key, node);
      }
    }
    return reader.complete() ? Result<void>{} : fail("the stream ends elsewhere");
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

  void code_node(SymbolReader& reader, int level, std::uint64_t key, const Node& node) {
    std::array<Node*, 8> child{};
    std::array<std::int64_t, 8> weight{};
    std::int64_t children = 0, all_weights = 0;
    for (std::uint64_t octant = 0; octant < 8; ++octant) {
      Level& below = levels_[static_cast<std::size_t>(level) + 1];
      const auto found = below.find(key << 3 | octant);
      if (found == below.end()) continue;
      child[octant] = &found->second;
      weight[octant] = found->second.weight;
      all_weights += weight[octant];
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

    // Compute the base values.
    std::array<Components, 8> base;
    base.fill(node.value);
    std::int64_t near_activity = predicts_ ? 0 : node.activity, near_weight = predicts_ ? 0 : 1;
    Components least = node.value, most = node.value;
    for (int octant = 0; octant < 8 && predicts_; ++octant) {
      if (child[static_cast<std::size_t>(octant)] == nullptr) continue;
      const int x = (octant & 1) != 0 ? 1 : -1, y = (octant & 2) != 0 ? 1 : -1,
                z = (octant & 4) != 0 ? 1 : -1;
      Components sum{};
      std::int64_t weights = 0;
      const auto add = [&](const Node* from, std::int64_t w) {
        if (from == nullptr) return;
        for (std::size_t k = 0; k < 3; ++k) sum[k] += w * from->value[k];
        weights += w;
        near_activity += w * from->activity;
      };
      add(&node, 18);
      for (const glm::ivec3& face : {glm::ivec3(x, 0, 0), glm::ivec3(0, y, 0), glm::ivec3(0, 0, z)})
        add(neighbor(level, key, face), 8);
      for (const glm::ivec3& edge : {glm::ivec3(x, y, 0), glm::ivec3(0, y, z), glm::ivec3(x, 0, z)})
        add(neighbor(level, key, edge), 3);
      Components& e = base[static_cast<std::size_t>(octant)];
      for (std::size_t k = 0; k < 3; ++k) {
        e[k] = (sum[k] * (65536 / weights) + (1 << 15)) >> 16;
        least[k] = std::min(least[k], e[k]);
        most[k] = std::max(most[k], e[k]);
      }
      near_weight += weights;
    }
    if (predicts_) {
      for (std::size_t k = 0; k < 3; ++k) {
        std::int64_t sum = 0;
        for (std::size_t octant = 0; octant < 8; ++octant) {
          sum += weight[octant] * (node.value[k] - base[octant][k]);
        }
        const std::int64_t shift = divided(2 * sum + all_weights, 2 * all_weights);
        for (Components& b : base) b[k] = std::clamp<std::int64_t>(b[k] + shift, -16384, 16383);
      }
    }

    // Determine the contexts.
    std::int64_t gradient = 0;
    if (predicts_) {
      std::int64_t range = most[0] - least[0];
      for (std::size_t k = 1; k < 3 && normals_; ++k) range = std::max(range, most[k] - least[k]);
      for (const int part : {1, 2, 4, 8}) gradient += 8 * range / part >= steps_[0] / 4;
    }
    int activity = near_activity > 0;
    for (const int half : {1, 2, 5, 12, 24, 48, 96}) {
      activity += near_activity > 0 && 2 * near_activity >= half * near_weight;
    }
    const int recent = recent_ < 6 ? 0 : recent_ < 48 ? 1 : 2;
    std::array<int, 8> moved_to{};
    const std::vector<Pair> pairs = pairs_of(weight, moved_to);
    const auto count = static_cast<int>(pairs.size());

    // Decode the coefficients.
    std::vector<Components> q(pairs.size());
    std::vector<bool> coded(pairs.size());  // from the last pair on
    int number_coded = 0, pattern = 0;
    const auto set_coded = [&](int from, int bits) {
      for (int i = from; i < count; ++i) {
        const bool is = (bits >> (i - from) & 1) != 0;
        coded[static_cast<std::size_t>(i)] = is;
        number_coded += is;
      }
    };
    if (count == 1) {
      pattern = reader.symbol(0, alphabets_("one", 8, {gradient, activity, recent}));
      set_coded(0, pattern != 0);
    } else if (count == 2) {
      set_coded(0, reader.symbol(0, alphabets_("two", 4, {gradient, activity, recent})) & 3);
    } else if (count == 3) {
      set_coded(0, reader.symbol(0, alphabets_("three", 8, {gradient, activity, recent})));
    } else if (reader.symbol(0, alphabets_("more", 2, {gradient, activity, recent})) != 0) {
      int symbols = 0;
      for (int i = 0; i < count; i += 3) {
        const int place = i == 0 ? 0 : symbols == 0 ? 1 : 2;
        const int bits = reader.symbol(0, alphabets_("pairs", 8, {gradient, activity, place}));
        symbols |= bits << i;
      }
      set_coded(0, symbols);
    }
    std::int64_t sum = 0;
    for (int i = 0; i < count; ++i) {
      if (!coded[static_cast<std::size_t>(i)]) continue;
      if (count > 1) {
        pattern = reader.symbol(0, alphabets_("pattern", 8, {activity, recent, number_coded > 1}));
      }
      q[static_cast<std::size_t>(count - 1 - i)] = triple(reader, pattern, activity, sum);
    }
    const std::int64_t now = std::min<std::int64_t>(127, exact_ ? sum / count : 4 * sum / count);
    recent_ += (std::min<std::int64_t>(4 * now, 256) - recent_) >> 2;

    // Turn them into differences.
    std::vector<Components> difference(pairs.size());
    if (exact_) {
      std::array<Components, 8> e = base;
      for (std::size_t i = 0; i < pairs.size(); ++i) {
        Components& lower = e[static_cast<std::size_t>(pairs[i].lower)];
        const Components& higher = e[static_cast<std::size_t>(pairs[i].higher)];
        for (std::size_t k = 0; k < 3; ++k) {
          const std::int64_t expected = higher[k] - lower[k];
          difference[i][k] = std::clamp<std::int64_t>(q[i][k] + expected, -65536, 65536);
          lower[k] += (expected * ratio_of(pairs[i]) + (1 << 13)) >> 14;
        }
      }
    } else {
      for (std::size_t i = 0; i < pairs.size(); ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
          const std::int64_t magnitude = std::min<std::int64_t>(
              (std::abs(q[i][k]) * step_of(pairs[i], steps_[k]) + (1 << 7)) >> 8, 1 << 16);
          difference[i][k] = q[i][k] < 0 ? -magnitude : magnitude;
        }
        if (normals_) difference[i] = reflected(difference[i], node.value);
      }
    }

    // Undo the transform.
    const auto top = static_cast<std::size_t>(moved_to[0]);
    for (std::size_t k = 0; k < 3; ++k) {
      std::array<std::int64_t, 8> v{};
      v[top] = exact_ ? node.value[k] : 0;
      for (std::size_t i = pairs.size(); i-- > 0;) {
        const std::int64_t d = difference[i][k];
        auto& lower = v[static_cast<std::size_t>(pairs[i].lower)];
        lower -= (d * ratio_of(pairs[i]) + (1 << 13)) >> 14;
        v[static_cast<std::size_t>(pairs[i].higher)] = lower + d;
      }
      for (std::size_t octant = 0; octant < 8; ++octant) {
        if (child[octant] == nullptr) continue;
        const std::int64_t add = exact_ ? 0 : base[octant][k];
        child[octant]->value[k] = std::clamp<std::int64_t>(v[octant] + add, -16384, 16383);
        child[octant]->activity = now;
      }
    }
  }

  static Components reflected(const Components& d, const Components& n) {
    const std::int64_t squared = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
    if (squared < 512 * 512) return d;
    auto length = static_cast<std::int64_t>(std::sqrt(static_cast<long double>(squared)));
    while (length * length > squared) --length;
    while ((length + 1) * (length + 1) <= squared) ++length;
    const Components u = {n[0], n[1], n[2] < 0 ? n[2] - length : n[2] + length};
    const std::int64_t inverse =
        (std::int64_t{1} << 45) / (u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
    const std::int64_t g = u[0] * d[0] + u[1] * d[1] + u[2] * d[2];
    const std::int64_t t = (g * inverse) >> 30;
    return {d[0] - ((u[0] * t) >> 14), d[1] - ((u[1] * t) >> 14), d[2] - ((u[2] * t) >> 14)};
  }

  /// Adds to `sum` how much there was to code.
  Components triple(SymbolReader& reader, int pattern, int activity, std::int64_t& sum) {
    Components q{};
    const int number = (pattern & 1) + (pattern >> 1 & 1) + (pattern >> 2);
    std::array<bool, 3> negative{};
    if (!normals_ && number > 1) {
      const int signs = reader.symbol(1, alphabets_("signs", 8, {pattern}));
      for (int k = 0; k < 3; ++k) negative[static_cast<std::size_t>(k)] = (signs >> k & 1) != 0;
    } else {
      for (int k = 0; k < 3; ++k) {
        if ((pattern >> k & 1) != 0) negative[static_cast<std::size_t>(k)] = reader.bits(1) != 0;
      }
    }
    for (int k = 0; k < 3; ++k) {
      if ((pattern >> k & 1) == 0) continue;
      std::int64_t magnitude =
          1 + reader.symbol(1, alphabets_("magnitude", 0, {k, activity, number > 1}));
      if (magnitude == 8) {
        int digits = 1 + reader.symbol(1, alphabets_("digits", 0, {k, activity}));
        const int first_digits = digits;
        if (digits == 8) digits += static_cast<int>(reader.bits(4));
        const int leading = std::min(digits - 1, 3);
        std::int64_t r = 1;
        if (leading > 0) {
          Alphabet& alphabet = alphabets_("leading", 1 << leading, {k, first_digits});
          r = (std::int64_t{1} << leading) | (reader.symbol(1, alphabet) & ((1 << leading) - 1));
        }
        const int others = digits - 1 - leading;
        magnitude = ((r << others) | reader.bits(others)) + 7;
      }
      sum += k == 0 || (k == 1 && normals_) ? 2 * magnitude : magnitude;
      const bool minus = negative[static_cast<std::size_t>(k)];
      q[static_cast<std::size_t>(k)] = minus ? -magnitude : magnitude;
    }
    return q;
  }

  bool normals_, predicts_ = false, exact_ = false;
  std::vector<Level> levels_;
  std::vector<bool> can_be_predicted_;
  Alphabets alphabets_;
  std::array<std::int64_t, 3> steps_{};
  std::int64_t recent_ = 0;
};

}  // namespace

Result<Values> decode_values(const std::vector<glm::uvec3>& leaves,
                             const std::vector<Bytes>& layers, const std::vector<int>& layer_ends,
                             bool normals) {
  Decoder decoder(leaves, layer_ends[layers.size() - 1], normals);
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
  const auto values = decode_values(leaves, layers, layer_ends, false);
  if (!values) return colors;
  for (const glm::ivec3& value : values->nodes) {
    colors.push_back(values->exact ? color_of_exact_value(value) : color_of_value(value, 8));
  }
  return colors;
}

}  // namespace pointreel::reference
