#include "tests/reference/context_decoder.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <map>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include <zstd.h>

#include "common/base/try.h"

namespace pointreel::reference {
namespace {

struct Cell {
  std::array<int, 3> at;  ///< x, y, z

  auto operator<=>(const Cell&) const = default;
};
using Cells = std::set<Cell>;

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

// --- Tables ---

/// `base`: what tables with the mask 2^63 are taken from.
Tables read_tables_on(ByteView file, const Tables& base) {
  constexpr std::array<std::int64_t, 16> kFrequencies = {
      1005861, 912838, 794672, 668237, 542777, 425854, 322737, 236257,
      167059,  114105, 72717,  43238,  23170,  10086,  2896,   362};
  constexpr std::array<int, 4> kSeen = {5, 11, 25, 57};
  Bytes bytes(ZSTD_getFrameContentSize(file.data(), file.size()));
  ZSTD_decompress(bytes.data(), bytes.size(), file.data(), file.size());
  std::size_t at = 0;
  const auto mask = [&] {
    std::uint64_t value = 0;
    for (int i = 0; i < 8; ++i) value |= static_cast<std::uint64_t>(bytes.at(at++)) << (8 * i);
    return value;
  };
  Tables tables;
  for (std::size_t t = 0; t < 15; ++t) {
    Table table;
    table.mask = mask();
    if (table.mask >> 63 != 0) {
      tables.push_back(base.at(t));
      continue;
    }
    std::size_t parts = 0, alphabets = 0;
    for (std::size_t c = std::size_t{1} << ones(table.mask); c > 0; --c) {
      table.cells.push_back({mask(), parts});
      parts += std::size_t{1} << ones(table.cells.back().mask);
    }
    for (std::size_t p = parts; p > 0; --p) {
      table.parts.push_back({mask(), alphabets});
      alphabets += std::size_t{1} << ones(table.parts.back().mask);
    }
    const std::size_t symbols = t == 0 || t == 3 || t == 6 ? 9 : 16;
    for (std::size_t a = 0; a < alphabets; ++a) {
      std::vector<std::int64_t> f(16, 0);
      for (std::size_t s = 0; s < symbols; ++s) {
        f[s] = kFrequencies[bytes.at(at + (s + 1) * alphabets + a) & 15];
      }
      table.alphabets.emplace_back(f);
      table.alphabets.back().set_seen(kSeen[bytes.at(at + a) & 3]);
    }
    at += alphabets * (symbols + 1);
    tables.push_back(std::move(table));
  }
  return tables;
}

Alphabet& find(Table& table, std::uint64_t word) {
  const Table::Entry& cell = table.cells.at(gather(word, table.mask));
  const Table::Entry& part = table.parts.at(cell.first + gather(word, cell.mask));
  return table.alphabets.at(part.first + gather(word, part.mask));
}

// --- Order ---

/// Whether a comes before b, if coordinates are compared from the highest bit on, and in each bit
/// the last axis first.
bool in_morton_order(const Cell& a, const Cell& b, int axes) {
  for (int bit = 30; bit >= 0; --bit) {
    for (int axis = axes - 1; axis >= 0; --axis) {
      const int p = a.at[static_cast<std::size_t>(axis)] >> bit & 1;
      const int q = b.at[static_cast<std::size_t>(axis)] >> bit & 1;
      if (p != q) return p < q;
    }
  }
  return false;
}

bool in_slice_order(const Cell& a, const Cell& b) {
  return a.at[2] != b.at[2] ? a.at[2] < b.at[2] : in_morton_order(a, b, 2);
}

Cell child_of(const Cell& node, int c) {
  return {{2 * node.at[0] + (c & 1), 2 * node.at[1] + (c >> 1 & 1), 2 * node.at[2] + (c >> 2)}};
}

// --- Words ---

/// The nodes around a node: entry [k + 1][j + 1][i + 1] tells about (x + i, y + j, z + k).
using Cube = std::array<std::array<std::array<int, 3>, 3>, 3>;

Cube around(const Cells& nodes, const Cell& node) {
  Cube cube{};
  for (int k = -1; k <= 1; ++k) {
    for (int j = -1; j <= 1; ++j) {
      for (int i = -1; i <= 1; ++i) {
        const bool itself = i == 0 && j == 0 && k == 0;
        const Cell other{{node.at[0] + i, node.at[1] + j, node.at[2] + k}};
        cube[static_cast<std::size_t>(k + 1)][static_cast<std::size_t>(j + 1)]
            [static_cast<std::size_t>(i + 1)] = !itself && nodes.contains(other) ? 1 : 0;
      }
    }
  }
  return cube;
}

struct Counts {
  std::array<int, 3> up{}, down{};
  int all = 0;
};

Counts count(const Cube& cube) {
  Counts counts;
  for (std::size_t i = 0; i < 27; ++i) {
    const std::array<std::size_t, 3> at = {i % 3, i / 3 % 3, i / 9};
    const int one = cube[at[2]][at[1]][at[0]];
    counts.all += one;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      counts.up[axis] += at[axis] == 2 ? one : 0;
      counts.down[axis] += at[axis] == 0 ? one : 0;
    }
  }
  return counts;
}

/// How a sparse level's node is turned: new axis a is the former axis `from[a]`, mirrored if
/// `mirrored[a]`.
struct Turn {
  std::array<std::size_t, 3> from = {0, 1, 2};
  std::array<bool, 3> mirrored{};

  /// The number of child c before it was turned.
  int turned_back(int c) const {
    int before = 0;
    for (std::size_t a = 0; a < 3; ++a) {
      before |= ((c >> a & 1) ^ (mirrored[a] ? 1 : 0)) << from[a];
    }
    return before;
  }
};

std::uint64_t sparse_word(const Cube& cube, const Counts& parent, const Cell& node, Turn& turn) {
  const Counts own = count(cube);
  struct Axis {
    std::size_t number;
    bool mirrored;
    int spread, score, fields;
  };
  std::vector<Axis> axes;
  for (std::size_t a = 0; a < 3; ++a) {
    const int octant = node.at[a] & 1;
    int u = own.up[a] - own.down[a], v = parent.up[a] - parent.down[a];
    const int score = 20 * u + 2 * v + 2 * octant - 1;
    const bool mirrored = score < 0;
    if (mirrored) {
      u = -u;
      v = -v;
    }
    const int fields = (octant ^ (mirrored ? 1 : 0)) + (v > 0 ? 2 : 0) + (v < 0 ? 4 : 0) +
                       (std::abs(v) > 2 ? 8 : 0) + (u > 0 ? 16 : 0) + (u > 2 ? 32 : 0);
    axes.push_back({a, mirrored, 4 * (own.up[a] + own.down[a]) + parent.up[a] + parent.down[a],
                    std::abs(score), fields});
  }
  std::stable_sort(axes.begin(), axes.end(), [](const Axis& a, const Axis& b) {
    return std::tuple(a.spread, -a.score, a.fields) < std::tuple(b.spread, -b.score, b.fields);
  });
  std::uint64_t word = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    turn.from[a] = axes[a].number;
    turn.mirrored[a] = axes[a].mirrored;
    word |= static_cast<std::uint64_t>(axes[a].fields) << (26 + 6 * a);
  }
  int bit = 0;
  for (std::size_t i = 0; i < 27; ++i) {
    if (i == 13) continue;
    const std::array<std::size_t, 3> turned = {i % 3, i / 3 % 3, i / 9};
    std::array<std::size_t, 3> at{};
    for (std::size_t a = 0; a < 3; ++a) {
      at[turn.from[a]] = turn.mirrored[a] ? 2 - turned[a] : turned[a];
    }
    word |= static_cast<std::uint64_t>(cube[at[2]][at[1]][at[0]]) << bit++;
  }
  const int n = own.all, m = parent.all;
  const unsigned density = n <= 2 ? 0 : n <= 5 ? 1 : n <= 9 ? 2 : 3;
  const unsigned density_above = m <= 4 ? 0 : m <= 7 ? 1 : m <= 10 ? 2 : 3;
  return word | std::uint64_t{density} << 44 | std::uint64_t{density_above} << 46;
}

/// `cells`: the children known so far of the slab's nodes.
std::uint64_t causal_word(const Cube& cube, const Cells& cells, const Cell& node) {
  std::uint64_t word = 0;
  int bit = 0;
  const auto cell = [&](int i, int j, int k) {
    const Cell at{{2 * node.at[0] + i, 2 * node.at[1] + j, 2 * node.at[2] + k}};
    word |= std::uint64_t{cells.contains(at)} << bit++;
  };
  for (int j = -1; j <= 2; ++j) {
    for (int i = -1; i <= 2; ++i) cell(i, j, -1);
  }
  cell(-1, -1, 0);
  cell(-1, -1, 1);
  cell(0, -1, 0);
  cell(1, -1, 0);
  cell(0, -1, 1);
  cell(1, -1, 1);
  cell(2, -1, 0);
  cell(2, -1, 1);
  for (int j = 0; j <= 2; ++j) {
    cell(-1, j, 0);
    cell(-1, j, 1);
  }
  for (std::size_t i = 0; i < 27; ++i) {
    if (i != 13) word |= static_cast<std::uint64_t>(cube[i / 9][i / 3 % 3][i % 3]) << bit++;
  }
  return word;
}

// --- Levels ---

/// The coder, the alphabets and the known cells of a slab.
struct Slab {
  SymbolReader reader;
  std::vector<Cell> nodes;
  Cells cells;
};

using Masks = std::map<Cell, int>;
using AllCounts = std::map<Cell, Counts>;

class LevelDecoder {
 public:
  LevelDecoder(int level_class, const Cells& nodes, const AllCounts& above, AllCounts& counts,
               Masks& masks)
      : class_(level_class), nodes_(nodes), above_(above), counts_(counts), masks_(masks) {}

  void decode(Slab& slab, Tables& tables) {
    // The tables of classes 0 to 2 are three each, and those of the others two each.
    const auto first = static_cast<std::size_t>(class_ < 3 ? 3 * class_ : 3 + 2 * class_);
    Table *only = class_ < 3 ? &tables.at(first) : nullptr,
          *low = &tables.at(first + (class_ < 3 ? 1 : 0)),
          *high = &tables.at(first + (class_ < 3 ? 2 : 1));
    for (const Cell& node : slab.nodes) counts_[node] = count(around(nodes_, node));
    if (only == nullptr) {
      if (class_ == 5 && nodes_.size() >= 16384) {
        for (Table* table : {low, high}) {
          for (Alphabet& alphabet : table->alphabets) alphabet.set_seen(0);
        }
      }
      for (const Cell& node : slab.nodes) {
        const std::uint64_t word = causal_word(around(nodes_, node), slab.cells, node);
        const int mask = halves(slab.reader, *low, *high, word, 56);
        keep(slab, node, mask);
      }
      return;
    }
    for (std::size_t begin = 0, end = 0; begin < slab.nodes.size(); begin = end) {
      while (end < slab.nodes.size() && slab.nodes[end].at[2] == slab.nodes[begin].at[2]) ++end;
      decode_slice(slab, begin, end, *only, *low, *high);
    }
  }

 private:
  static int halves(SymbolReader& reader, Table& low, Table& high, std::uint64_t word, int bit) {
    const int l = reader.symbol(0, find(low, word));
    return l | reader.symbol(1, find(high, word | static_cast<std::uint64_t>(l) << bit)) << 4;
  }

  void keep(Slab& slab, const Cell& node, int mask) {
    masks_[node] = mask;
    for (int c = 0; c < 8; ++c) {
      if (mask >> c & 1) slab.cells.insert(child_of(node, c));
    }
  }

  void decode_slice(Slab& slab, std::size_t begin, std::size_t end, Table& only, Table& low,
                    Table& high) {
    std::vector<Turn> turns(end - begin);
    std::vector<std::uint64_t> words;
    std::vector<int> masks(end - begin, 0);
    for (std::size_t i = begin; i < end; ++i) {
      const Cell& node = slab.nodes[i];
      const auto parent = above_.find({{node.at[0] / 2, node.at[1] / 2, node.at[2] / 2}});
      words.push_back(sparse_word(around(nodes_, node),
                                  parent == above_.end() ? Counts{} : parent->second, node,
                                  turns[i - begin]));
    }
    for (std::size_t i = 0; i < words.size(); ++i) {
      const int symbol = slab.reader.symbol(static_cast<int>(i % 2), find(only, words[i]));
      if (symbol < 8) masks[i] = 1 << symbol;
    }
    for (std::size_t i = 0; i < words.size(); ++i) {
      if (masks[i] == 0) masks[i] = halves(slab.reader, low, high, words[i], 48);
      int mask = 0;
      for (int c = 0; c < 8; ++c) {
        if (masks[i] >> c & 1) mask |= 1 << turns[i].turned_back(c);
      }
      keep(slab, slab.nodes[begin + i], mask);
    }
  }

  int class_;
  const Cells& nodes_;
  const AllCounts& above_;
  AllCounts& counts_;
  Masks& masks_;
};

/// Reads how the layer is divided into slabs, and starts their coders. `begins`: their first z.
Result<std::vector<Slab>> read_slabs(ByteView bytes, int level, std::size_t masks,
                                     std::vector<int>& begins) {
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
  if (count != begins.size()) {
    if (begins.size() > 1) return fail("other slabs");
    if (count * 4096 > masks) return fail("too few masks for slabs");
    while (begins.size() < count) {
      const int begin = static_cast<int>(number(2));
      if (begin <= begins.back() || begin >= 1 << level) return fail("no such slab");
      begins.push_back(begin);
    }
  }
  std::vector<std::size_t> sizes;
  for (std::size_t i = 1; i < count; ++i) sizes.push_back(number(4));
  std::vector<Slab> slabs;
  for (std::size_t i = 0; i < count; ++i) {
    if (at > bytes.size()) return fail("no slab");
    const std::size_t size = i + 1 < count ? sizes[i] : bytes.size() - at;
    if (size > bytes.size() - at) return fail("no slab");
    slabs.push_back({SymbolReader(bytes.subspan(at, size)), {}, {}});
    at += size;
  }
  return slabs;
}

}  // namespace

Tables read_tables(ByteView file) { return read_tables_on(file, {}); }

Tables read_package_tables(ByteView file, const Tables& tables1) {
  return read_tables_on(file.subspan(1), tables1);
}

Result<Bytes> decode_context_layers(const std::vector<ContextLayer>& layers, const Tables& tables1,
                                    const Tables* own) {
  std::vector<Tables> tables;  // of each slab
  Cells nodes = {{{0, 0, 0}}};
  AllCounts above;
  Bytes masks;
  std::vector<int> begins = {0};
  for (std::size_t number = 0; number < layers.size(); ++number) {
    ByteView payload = layers[number].payload;
    if (number == 0) {
      if (payload.empty() || (payload[0] != 1 && payload[0] != 255)) return fail("no such tables");
      if (payload[0] == 255 && (own == nullptr || payload.size() < 9)) return fail("no own tables");
      tables = {payload[0] == 255 ? *own : tables1};
      payload = payload.subspan(payload[0] == 255 ? 9 : 1);
    }
    const auto levels =
        static_cast<std::size_t>(layers[number].last_level - layers[number].first_level);
    if (payload.size() < levels) return fail("no level classes");
    auto slabs = TRY(read_slabs(payload.subspan(levels), layers[number].first_level,
                                layers[number].masks, begins));
    tables.resize(slabs.size(), tables.front());
    const std::size_t end = masks.size() + layers[number].masks;
    for (std::size_t l = 0; l < levels; ++l) {
      const int level = layers[number].first_level + static_cast<int>(l);
      if (payload[l] > 5) return fail("no such level class");
      if (nodes.size() > end - masks.size()) return fail("more masks than told");
      if (payload[l] >= 3 && 1ull << (2 * level) > 32768 + 32 * nodes.size()) {
        return fail("too few nodes for the class of a level");
      }
      std::vector<Cell> ordered(nodes.begin(), nodes.end());
      std::sort(ordered.begin(), ordered.end(), in_slice_order);
      AllCounts counts;
      Masks of_level;
      for (std::size_t s = 0; s < slabs.size(); ++s) {
        slabs[s].nodes.clear();
        slabs[s].cells.clear();
        for (const Cell& node : ordered) {
          const bool before_end = s + 1 == slabs.size() || node.at[2] < begins[s + 1];
          if (node.at[2] >= begins[s] && before_end) slabs[s].nodes.push_back(node);
        }
        LevelDecoder(payload[l], nodes, above, counts, of_level).decode(slabs[s], tables[s]);
      }
      std::sort(ordered.begin(), ordered.end(),
                [](const Cell& a, const Cell& b) { return in_morton_order(a, b, 3); });
      nodes.clear();
      for (const Cell& node : ordered) {
        const int mask = of_level.at(node);
        if (mask == 0) return fail("a node without children");
        masks.push_back(static_cast<std::uint8_t>(mask));
        for (int c = 0; c < 8; ++c) {
          if (mask >> c & 1) nodes.insert(child_of(node, c));
        }
      }
      above = std::move(counts);
      for (int& begin : begins) begin *= 2;
    }
    if (masks.size() != end) return fail("fewer masks than told");
    for (const Slab& slab : slabs) {
      if (!slab.reader.complete_but_for_zeros()) return fail("coded bytes end elsewhere");
    }
  }
  return masks;
}

}  // namespace pointreel::reference
