#include "tests/reference/context_decoder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <tuple>
#include <vector>

#include <zstd.h>

#include "common/base/try.h"

namespace pointreel::reference {
namespace {

using Cell = std::tuple<int, int, int>;  // z, y, x, so that cells sort in raster order

constexpr std::array<int, 64> kProbabilities = {
    49,    61,    77,    97,    122,   153,   192,   241,   303,   381,   478,   599,   751,
    941,   1179,  1475,  1843,  2299,  2864,  3559,  4412,  5451,  6707,  8214,  10001, 12096,
    14514, 17260, 20318, 23652, 27205, 30898, 34638, 38331, 41884, 45218, 48276, 51022, 53440,
    55535, 57322, 58829, 60085, 61124, 61977, 62672, 63237, 63693, 64061, 64357, 64595, 64785,
    64937, 65058, 65155, 65233, 65295, 65344, 65383, 65414, 65439, 65459, 65475, 65487};

std::uint64_t gather(std::uint64_t word, std::uint64_t mask) {
  std::uint64_t out = 0;
  int to = 0;
  for (int from = 0; from < 64; ++from) {
    if ((mask >> from & 1) == 0) continue;
    out |= (word >> from & 1) << to;
    ++to;
  }
  return out;
}

std::size_t ones(std::uint64_t mask) {
  std::size_t count = 0;
  for (int i = 0; i < 64; ++i) count += mask >> i & 1;
  return count;
}

/// `base`: the tables that slots with the mask 2^63 are taken from.
Tables read_tables_on(ByteView file, const Tables& base) {
  Bytes bytes(ZSTD_getFrameContentSize(file.data(), file.size()));
  ZSTD_decompress(bytes.data(), bytes.size(), file.data(), file.size());
  std::size_t at = 0;
  const auto mask = [&] {
    std::uint64_t value = 0;
    for (int i = 0; i < 8; ++i) value |= static_cast<std::uint64_t>(bytes.at(at++)) << (8 * i);
    return value;
  };
  Tables tables;
  std::vector<bool> stored;
  std::size_t cells = 0;
  for (std::size_t i = 0; i < 6 * 16; ++i) {
    std::uint64_t slot = mask();
    stored.push_back(slot >> 63 == 0);
    if (!stored[i]) slot = base.slots.at(i).mask;
    tables.slots.push_back({slot, cells});
    cells += std::size_t{1} << ones(slot);
  }
  for (std::size_t i = 0; i < 6 * 16; ++i) {
    const std::size_t count = std::size_t{1} << ones(tables.slots[i].mask);
    for (std::size_t c = 0; c < count; ++c) {
      tables.cells.push_back({stored[i] ? mask() : base.cells.at(base.slots[i].first + c).mask, 0});
    }
  }
  constexpr std::array<int, 4> kCounts = {1, 3, 8, 16};
  for (std::size_t i = 0; i < 6 * 16; ++i) {
    const std::size_t count = std::size_t{1} << ones(tables.slots[i].mask);
    for (std::size_t c = 0; c < count; ++c) {
      Tables::Entry& cell = tables.cells.at(tables.slots[i].first + c);
      cell.first = tables.leaves.size();
      const std::size_t leaves = std::size_t{1} << ones(cell.mask);
      for (std::size_t l = 0; l < leaves; ++l) {
        if (!stored[i]) {
          tables.leaves.push_back(base.leaves.at(base.cells[base.slots[i].first + c].first + l));
          continue;
        }
        const unsigned v = bytes.at(at++);
        tables.leaves.push_back({kProbabilities[v >> 2], kCounts[v & 3]});
      }
    }
  }
  return tables;
}

class Coder {
 public:
  explicit Coder(ByteView bytes) : bytes_(bytes) {
    for (int i = 0; i < 8; ++i) value_ = value_ << 8 | next();
  }

  int decide(long long p) {
    const std::uint64_t one = (range_ >> 16) * static_cast<std::uint64_t>(p);
    const int bit = value_ < one ? 1 : 0;
    if (bit == 0) value_ -= one;
    range_ = bit == 1 ? one : range_ - one;
    if (range_ < 4294967296) {
      range_ <<= 32;
      for (int i = 0; i < 4; ++i) value_ = value_ << 8 | next();
    }
    return bit;
  }

  /// True if the bytes end where the decisions do, apart from zeros.
  bool complete() const {
    if (at_ - 4 > bytes_.size()) return false;
    for (std::size_t i = at_ - 4; i < bytes_.size(); ++i) {
      if (bytes_[i] != 0) return false;
    }
    return true;
  }

 private:
  std::uint64_t next() {
    const std::size_t at = at_++;
    return at < bytes_.size() ? bytes_[at] : 0;
  }

  ByteView bytes_;
  std::size_t at_ = 0;
  std::uint64_t range_ = 0xffffffffffffffff, value_ = 0;
};

/// What is known while a level is decoded.
struct Level {
  std::set<Cell> nodes;
  std::map<Cell, int> masks;  ///< of the nodes decoded so far
  std::set<Cell> cells;       ///< their children
};

std::uint64_t word_of(const Level& level, int x, int y, int z) {
  std::uint64_t word = 0;
  const auto cell = [&](int bit, int cx, int cy, int cz) {
    if (level.cells.contains({cz, cy, cx})) word |= std::uint64_t{1} << bit;
  };
  for (int j = 0; j < 4; ++j) {
    for (int i = 0; i < 4; ++i) cell(4 * j + i, 2 * x - 1 + i, 2 * y - 1 + j, 2 * z - 1);
  }
  for (int i = 0; i < 4; ++i) {
    cell(16 + i, 2 * x - 1 + i, 2 * y - 1, 2 * z);
    cell(20 + i, 2 * x - 1 + i, 2 * y - 1, 2 * z + 1);
  }
  for (int k = 0; k < 2; ++k) {
    for (int j = 0; j < 2; ++j) cell(24 + 2 * k + j, 2 * x - 1, 2 * y + j, 2 * z + k);
  }
  int bit = 35;
  int around = 0;
  for (int k = -1; k <= 1; ++k) {
    for (int j = -1; j <= 1; ++j) {
      for (int i = -1; i <= 1; ++i) {
        if (i == 0 && j == 0 && k == 0) continue;
        if (level.nodes.contains({z + k, y + j, x + i})) {
          word |= std::uint64_t{1} << bit;
          ++around;
        }
        ++bit;
      }
    }
  }
  const std::uint64_t density = around <= 2 ? 0 : around <= 5 ? 1 : around <= 9 ? 2 : 3;
  return word | density << 61;
}

/// The word for classes 0 to 2, from the common one and that of the parent.
std::uint64_t sparse_word(std::uint64_t word, std::uint64_t parent, int x, int y, int z) {
  std::uint64_t out = word >> 28 << 28;
  int to = 0;
  for (const int from : {5, 6, 9, 10, 17, 18, 21, 22, 24, 25, 26, 27}) {
    out |= (word >> from & 1) << to++;
  }
  for (const int coordinate : {x, y, z}) out |= static_cast<std::uint64_t>(coordinate & 1) << to++;
  int up[3] = {}, down[3] = {}, all = 0, bit = 35;
  for (int k = -1; k <= 1; ++k) {
    for (int j = -1; j <= 1; ++j) {
      for (int i = -1; i <= 1; ++i) {
        if (i == 0 && j == 0 && k == 0) continue;
        if ((parent >> bit++ & 1) == 0) continue;
        ++all;
        const int offset[3] = {i, j, k};
        for (int axis = 0; axis < 3; ++axis) {
          up[axis] += offset[axis] == 1 ? 1 : 0;
          down[axis] += offset[axis] == -1 ? 1 : 0;
        }
      }
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    const int u = up[axis], d = down[axis];
    out |= static_cast<std::uint64_t>(u > d) << to++;
    out |= static_cast<std::uint64_t>(u < d) << to++;
    out |= static_cast<std::uint64_t>(u - d > 2 || d - u > 2) << to++;
  }
  return out | static_cast<std::uint64_t>(all <= 4 ? 0 : all <= 7 ? 1 : all <= 10 ? 2 : 3) << 24;
}

class LevelDecoder {
 public:
  LevelDecoder(Tables& tables, Coder& coder, int level_class)
      : tables_(tables), coder_(coder), class_(level_class) {}

  int mask(std::uint64_t word) {
    int least = 1;
    if (class_ <= 2) {
      if (decide(8, word) == 1) {
        int child = decide(9, word);
        child = 2 * child + decide(10 + child, word);
        child = 2 * child + decide(12 + child, word);
        return 1 << child;
      }
      least = 2;
    }
    int mask = 0, count = 0;
    for (int child = 0; child < 8; ++child) {
      // All of children `child` to 7 are needed to reach the minimum number.
      const bool must = count + (8 - child) == least;
      const std::uint64_t own = static_cast<std::uint64_t>(mask) << 28;
      const int bit = must ? 1 : decide(child, word | own);
      mask |= bit << child;
      count += bit;
    }
    return mask;
  }

 private:
  int decide(int slot, std::uint64_t word) {
    const auto& s = tables_.slots.at(static_cast<std::size_t>(class_ * 16 + slot));
    const auto& cell = tables_.cells.at(s.first + gather(word, s.mask));
    auto& leaf = tables_.leaves.at(cell.first + gather(word, cell.mask));
    const int bit = coder_.decide(leaf.p);
    const long long step = ((bit == 1 ? 65535 : 0) - leaf.p) * (655360 / (10 * leaf.n + 16));
    leaf.p += static_cast<long long>(std::floor(static_cast<double>(step) / 65536.0));
    leaf.p = std::min(std::max(leaf.p, 32LL), 65504LL);
    leaf.n = std::min(leaf.n + 1, 255LL);
    return bit;
  }

  Tables& tables_;
  Coder& coder_;
  int class_;
};

bool in_morton_order(const Cell& a, const Cell& b) {
  // The highest bit that differs decides, and if there are several, z before y before x.
  const auto [az, ay, ax] = a;
  const auto [bz, by, bx] = b;
  for (int bit = 30; bit >= 0; --bit) {
    for (const auto& [p, q] : {std::pair{az, bz}, {ay, by}, {ax, bx}}) {
      if ((p >> bit & 1) != (q >> bit & 1)) return (p >> bit & 1) < (q >> bit & 1);
    }
  }
  return false;
}

/// How a level is divided into slabs.
struct Slabs {
  int axis = 2;
  std::vector<int> begins = {0};

  std::size_t of(const Cell& cell) const {
    const int at = axis == 1 ? std::get<1>(cell) : std::get<0>(cell);
    std::size_t slab = 0;
    while (slab + 1 < begins.size() && at >= begins[slab + 1]) ++slab;
    return slab;
  }
};

/// What a slab knows while a level is decoded.
struct SlabDecoder {
  Coder coder;
  std::vector<Cell> nodes;
  std::size_t next = 0;
  Level level;
  Tables tables;
};

using Words = std::map<Cell, std::uint64_t>;

void decode_node(SlabDecoder& slab, const Cell& node, int level_class, const Words& words_above,
                 Words& words) {
  const auto [z, y, x] = node;
  std::uint64_t word = words[node] = word_of(slab.level, x, y, z);
  if (level_class <= 2) {
    const auto parent = words_above.find({z / 2, y / 2, x / 2});
    word = sparse_word(word, parent == words_above.end() ? 0 : parent->second, x, y, z);
  }
  const int mask = LevelDecoder(slab.tables, slab.coder, level_class).mask(word);
  slab.level.masks[node] = mask;
  for (int c = 0; c < 8; ++c) {
    if (mask >> c & 1) {
      slab.level.cells.insert({2 * z + (c >> 2), 2 * y + (c >> 1 & 1), 2 * x + (c & 1)});
    }
  }
}

Tables::Leaf merged(const Tables::Leaf& before, const std::vector<Tables::Leaf>& slabs) {
  const auto m = [](long long n) { return 10 * n + 6; };
  long long sum = m(before.n) * before.p, weights = m(before.n), n = before.n;
  long long least = before.p, most = before.p;
  bool limits = false;
  for (const Tables::Leaf& leaf : slabs) {
    sum += m(leaf.n) * leaf.p - m(before.n) * before.p;
    weights += m(leaf.n) - m(before.n);
    n += leaf.n - before.n;
    least = std::min(least, leaf.p);
    most = std::max(most, leaf.p);
    limits = limits || leaf.n == 255;
  }
  if (!limits) {
    least = 32;
    most = 65504;
  }
  const long long p = sum / weights;  // rounds up only where it is below 32 anyway
  return {std::min(std::max(p, least), most), std::min(n, 255LL)};
}

void decode_level(std::vector<SlabDecoder>& slabs, int level_class, Tables& tables,
                  const Words& words_above, Words& words) {
  std::size_t nodes = 0;
  for (const SlabDecoder& slab : slabs) nodes += slab.nodes.size();
  if (level_class == 5 && nodes >= 16384) {
    const std::size_t first_cell = tables.slots[5 * 16].first;
    for (std::size_t i = tables.cells[first_cell].first; i < tables.leaves.size(); ++i) {
      tables.leaves[i].n = std::min(tables.leaves[i].n, decltype(tables.leaves[i].n){6});
    }
  }
  const int phases = slabs.size() == 1 ? 1 : 4;
  for (int phase = 0; phase < phases; ++phase) {
    for (SlabDecoder& slab : slabs) {
      slab.tables = tables;
      const std::size_t until = slab.nodes.size() >> (phases - 1 - phase);
      const auto same_slice = [&slab] {
        return slab.next > 0 && slab.next < slab.nodes.size() &&
               std::get<0>(slab.nodes[slab.next]) == std::get<0>(slab.nodes[slab.next - 1]);
      };
      while (slab.next < until || same_slice()) {
        decode_node(slab, slab.nodes[slab.next++], level_class, words_above, words);
      }
    }
    if (slabs.size() == 1) {
      tables.leaves = slabs[0].tables.leaves;
      continue;
    }
    std::vector<Tables::Leaf> of_slabs(slabs.size());
    for (std::size_t i = 0; i < tables.leaves.size(); ++i) {
      for (std::size_t s = 0; s < slabs.size(); ++s) of_slabs[s] = slabs[s].tables.leaves[i];
      tables.leaves[i] = merged(tables.leaves[i], of_slabs);
    }
  }
}

/// Reads how the layer is divided into slabs, and starts their range decoders.
Result<std::vector<SlabDecoder>> read_slabs(ByteView bytes, int level, std::size_t masks,
                                            Slabs& slabs) {
  std::size_t at = 0;
  const auto number = [&](int size) {
    std::size_t value = 0;
    for (int i = 0; i < size; ++i, ++at) {
      value |= at < bytes.size() ? std::size_t{bytes[at]} << (8 * i) : 0;
    }
    return value;
  };
  const std::size_t count = number(1);
  if (count == 0 || count > 16) return fail("no such number of slabs");
  if (count != slabs.begins.size()) {
    if (slabs.begins.size() > 1) return fail("other slabs");
    if (count * 4096 > masks) return fail("too few masks for slabs");
    slabs.axis = static_cast<int>(number(1));
    if (slabs.axis != 1 && slabs.axis != 2) return fail("no such axis");
    while (slabs.begins.size() < count) {
      const int begin = static_cast<int>(number(2));
      if (begin <= slabs.begins.back() || begin >= 1 << level) return fail("no such slab");
      slabs.begins.push_back(begin);
    }
  }
  std::vector<std::size_t> sizes;
  for (std::size_t i = 1; i < count; ++i) sizes.push_back(number(4));
  std::vector<SlabDecoder> decoders;
  for (std::size_t i = 0; i < count; ++i) {
    if (at > bytes.size()) return fail("no slab");
    const std::size_t size = i + 1 < count ? sizes[i] : bytes.size() - at;
    if (size > bytes.size() - at) return fail("no slab");
    decoders.push_back({Coder(bytes.subspan(at, size)), {}, 0, {}, {}});
    at += size;
  }
  return decoders;
}

}  // namespace

Tables read_tables(ByteView file) { return read_tables_on(file, {}); }

Tables read_package_tables(ByteView file, const Tables& tables1) {
  return read_tables_on(file.subspan(1), tables1);
}

Result<Bytes> decode_context_layers(const std::vector<ContextLayer>& layers, const Tables& tables1,
                                    const Tables* own) {
  Tables tables;
  std::set<Cell> nodes = {{0, 0, 0}};
  Words words_above;
  Bytes masks;
  Slabs slabs;
  for (std::size_t number = 0; number < layers.size(); ++number) {
    ByteView payload = layers[number].payload;
    if (number == 0) {
      if (payload.empty() || (payload[0] != 1 && payload[0] != 255)) return fail("no such tables");
      if (payload[0] == 255 && (own == nullptr || payload.size() < 9)) return fail("no own tables");
      tables = payload[0] == 255 ? *own : tables1;
      payload = payload.subspan(payload[0] == 255 ? 9 : 1);
    }
    const auto levels =
        static_cast<std::size_t>(layers[number].last_level - layers[number].first_level);
    if (payload.size() < levels) return fail("no level classes");
    auto decoders = TRY(read_slabs(payload.subspan(levels), layers[number].first_level,
                                   layers[number].masks, slabs));
    const std::size_t end = masks.size() + layers[number].masks;
    for (std::size_t l = 0; l < levels; ++l) {
      if (payload[l] > 5) return fail("no such level class");
      if (nodes.size() > end - masks.size()) return fail("more masks than told");
      for (SlabDecoder& slab : decoders) {
        slab.level = {nodes, {}, {}};
        slab.nodes.clear();
        slab.next = 0;
      }
      for (const Cell& node : nodes) decoders[slabs.of(node)].nodes.push_back(node);
      Words words;
      decode_level(decoders, payload[l], tables, words_above, words);
      std::vector<Cell> ordered(nodes.begin(), nodes.end());
      std::sort(ordered.begin(), ordered.end(), in_morton_order);
      for (const Cell& node : ordered) {
        const SlabDecoder& slab = decoders[slabs.of(node)];
        masks.push_back(static_cast<std::uint8_t>(slab.level.masks.at(node)));
      }
      nodes.clear();
      for (const SlabDecoder& slab : decoders) {
        nodes.insert(slab.level.cells.begin(), slab.level.cells.end());
      }
      words_above = words;
      for (int& begin : slabs.begins) begin *= 2;
    }
    if (masks.size() != end) return fail("fewer masks than told");
    for (const SlabDecoder& slab : decoders) {
      if (!slab.coder.complete()) return fail("coded bytes end elsewhere");
    }
  }
  return masks;
}

}  // namespace pointreel::reference
