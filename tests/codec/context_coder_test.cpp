#include "codec/octree/context_coder.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <fstream>
#include <iterator>
#include <memory>
#include <random>

#include <gtest/gtest.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "codec/core/morton.h"
#include "codec/octree/context_tables.h"
#include "codec/octree/node_planes.h"
#include "codec/octree/orientation.h"
#include "codec/octree/slice_level.h"
#include "codec/octree/sparse_words.h"
#include "pointreel/cpu.h"
#include "pointreel/octree.h"
#include "pointreel/package.h"
#include "tests/paths.h"
#include "tests/portable_code.h"
#include "tests/reference/context_decoder.h"
#include "tests/tree_of_cells.h"

namespace pointreel::context_coder_test {
namespace {

/// Random cells in clusters, so that some places are dense and some are sparse.
Svo clustered_tree(int depth, std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  const std::uint32_t side = 1u << depth;
  std::vector<glm::uvec3> cells;
  glm::uvec3 center(0);
  for (std::size_t i = 0; i < count; ++i) {
    if (i % 40 == 0) center = {random() % side, random() % side, random() % side};
    const std::uint32_t spread = std::min(side, 1u << (i / 40 % 4));
    cells.push_back({(center.x + random() % spread) % side, (center.y + random() % spread) % side,
                     (center.z + random() % spread) % side});
  }
  return tree_of_cells(cells, depth);
}

/// A bumpy shell, computed with integers only.
Svo shell_tree(int depth, std::int64_t thickness) {
  const std::int64_t side = std::int64_t{1} << depth, radius = side * 3 / 8;
  std::vector<glm::uvec3> cells;
  for (std::int64_t z = 0; z < side; ++z) {
    for (std::int64_t y = 0; y < side; ++y) {
      for (std::int64_t x = 0; x < side; ++x) {
        const std::int64_t dx = x - side / 2, dy = y - side / 2, dz = z - side / 2;
        const std::int64_t square = dx * dx + dy * dy + dz * dz + (dx * dy * dz) / side;
        if (std::abs(square - radius * radius) < thickness * radius) {
          cells.push_back(
              {static_cast<unsigned>(x), static_cast<unsigned>(y), static_cast<unsigned>(z)});
        }
      }
    }
  }
  return tree_of_cells(cells, depth);
}

/// A sheet with steps whose last coded level is large and belongs to the densest class.
Svo sheet_tree() {
  std::vector<glm::uvec3> cells;
  for (std::uint32_t y = 0; y < 256; ++y) {
    for (std::uint32_t x = 0; x < 256; ++x) cells.push_back({x, y, 100 + (x * x + 3 * y) / 9000});
  }
  return tree_of_cells(cells, 8);
}

Svo full_tree(int depth) {
  Svo svo;
  svo.depth = depth;
  for (int level = 0; level < depth; ++level) {
    svo.masks.insert(svo.masks.end(), std::size_t{1} << (3 * level), 0xff);
  }
  index_svo(svo, true);
  return svo;
}

/// The level below, with the masks of the tree.
SliceLevel next_level(const Svo& svo, SliceLevel& level) {
  const std::size_t begin = svo.level_begin[static_cast<std::size_t>(level.level)];
  std::vector<std::uint32_t> first_child(level.size());
  for (std::size_t i = 0; i < level.size(); ++i) {
    level.masks[i] = svo.masks[begin + level.rank[i]];
    first_child[i] =
        svo.first_child[begin + i] - svo.level_begin[static_cast<std::size_t>(level.level) + 1];
  }
  SliceLevel below;
  expand(level, first_child, svo.node_count(level.level + 1), below);
  return below;
}

std::shared_ptr<const ContextTables> tables() { return tables_of_number(1).value(); }

std::vector<Bytes> encode(const Svo& svo, const std::vector<int>& ends) {
  ContextEncoder encoder(tables(), 1);
  std::vector<Bytes> layers;
  int begin = 0;
  for (const int end : ends) {
    encoder.encode_layer(svo, begin, end, layers.emplace_back());
    begin = end;
  }
  return layers;
}

Result<Bytes> decode(const Svo& svo, const std::vector<Bytes>& layers,
                     const std::vector<int>& ends) {
  ContextDecoder decoder(tables());
  Bytes masks;
  int begin = 0;
  for (std::size_t i = 0; i < layers.size(); ++i) {
    // The buffer ends with the payload, so that a read past the end is noticed.
    const auto exact = std::make_unique<std::uint8_t[]>(layers[i].size());
    std::copy(layers[i].begin(), layers[i].end(), exact.get());
    const std::size_t count = svo.level_begin[static_cast<std::size_t>(ends[i])] -
                              svo.level_begin[static_cast<std::size_t>(begin)];
    const auto done = decoder.decode_layer({exact.get(), layers[i].size()}, begin, ends[i], count,
                                           svo.leaf_count(), masks);
    if (!done) return tl::unexpected(done.error());
    begin = ends[i];
  }
  return masks;
}

std::vector<Svo> small_trees() {
  return {tree_of_cells({{0, 0, 0}}, 1),
          tree_of_cells({{5, 9, 14}}, 4),
          tree_of_cells({{0, 0, 0}, {255, 255, 255}, {255, 0, 7}}, 8),
          full_tree(3),
          shell_tree(5, 3),
          clustered_tree(6, 700, 1),
          clustered_tree(9, 900, 2),
          clustered_tree(kMaxDepth, 300, 3)};
}

TEST(SliceLevel, puts_nodes_in_order_of_z_and_in_morton_order_within_a_slice) {
  const Svo svo = clustered_tree(6, 500, 1);
  SliceLevel level = root_level();
  for (int number = 0; number < svo.depth; ++number) level = next_level(svo, level);
  const std::vector<glm::uvec3> cells = leaf_cells(svo);
  ASSERT_EQ(level.size(), cells.size());
  std::uint64_t last = 0;
  for (std::size_t s = 0; s < level.slice_count(); ++s) {
    for (std::uint32_t i = level.slices[s].begin; i < level.slices[s + 1].begin; ++i) {
      const glm::uvec3 cell(level.x[i], level.y[i], level.slices[s].z);
      EXPECT_EQ(cell, cells[level.rank[i]]);
      const std::uint64_t key =
          std::uint64_t{cell.z} << 40 | morton_encode(glm::uvec3(cell.x, cell.y, 0));
      EXPECT_TRUE(i == 0 || key > last);
      last = key;
    }
    EXPECT_EQ(slice_from(level, level.slices[s].z), s);
  }
  EXPECT_EQ(slice_from(level, 64), level.slice_count());
}

TEST(NodePlanes, find_the_same_neighbours_as_searching) {
  for (const Svo& svo :
       {shell_tree(5, 4), clustered_tree(7, 3000, 1), clustered_tree(9, 2000, 2)}) {
    SliceLevel level = root_level();
    for (int number = 0; number < svo.depth; ++number) {
      NodePlanes planes(level);
      NodeSearch search(level);
      for (std::size_t s = 0; s < level.slice_count(); ++s) {
        planes.move_to(s);
        search.visit(s, [&](std::uint32_t i, const CellsAround& found) {
          const CellsAround around = planes.around(level.x[i], level.y[i]);
          ASSERT_EQ(found.cube(), around.cube()) << "level " << number << " node " << i;
          ASSERT_EQ(static_cast<int>(around.sums() >> 24), std::popcount(around.cube()));
        });
      }
      level = next_level(svo, level);
    }
  }
}

TEST(Orientation, turns_masks_back) {
  for (std::size_t o = 0; o < orientation::kCount; ++o) {
    for (std::size_t mask = 0; mask < 256; ++mask) {
      const std::uint8_t turned = orientation::kTurned[o][mask];
      ASSERT_EQ(orientation::kTurnedBack[o][turned], mask);
      ASSERT_EQ(std::popcount(turned), std::popcount(mask));
    }
  }
}

/// The cells with x, y, z mirrored and exchanged.
Svo turned(const Svo& svo, unsigned orientation) {
  std::vector<glm::uvec3> cells = leaf_cells(svo);
  const std::uint32_t last = (1u << svo.depth) - 1;
  for (glm::uvec3& cell : cells) {
    for (int axis = 0; axis < 3; ++axis) {
      if ((orientation >> axis & 1u) != 0) cell[axis] = last - cell[axis];
    }
    if ((orientation & 8u) != 0) std::swap(cell.x, cell.y);
    if ((orientation & 16u) != 0) std::swap(cell.y, cell.z);
  }
  return tree_of_cells(cells, svo.depth);
}

TEST(SparseWalk, gives_the_same_words_however_the_tree_is_turned) {
  const Svo svo = clustered_tree(7, 2000, 5);
  const auto words_of = [](const Svo& tree) {
    std::vector<std::uint64_t> words;
    SliceLevel level = root_level();
    for (int number = 0; number < tree.depth; ++number) {
      SparseWalk walk(level);
      for (std::size_t s = 0; s < level.slice_count(); ++s) {
        walk.visit(s);
        for (std::size_t i = 0; i < walk.size(); ++i) {
          words.push_back(walk.word(i));
        }
      }
      level = next_level(tree, level);
    }
    std::sort(words.begin(), words.end());
    return words;
  };
  const auto words = words_of(svo);
  for (const unsigned orientation : {1u, 2u, 4u, 8u, 16u, 31u}) {
    const auto others = words_of(turned(svo, orientation));
    std::vector<std::uint64_t> common;
    std::set_intersection(words.begin(), words.end(), others.begin(), others.end(),
                          std::back_inserter(common));
    // Where two axes look alike, either may come first.
    EXPECT_GT(common.size(), words.size() * 9 / 10) << orientation;
  }
}

TEST(SparseWalk, gives_the_same_words_with_and_without_wide_vectors) {
  const Svo svo = shell_tree(6, 3);
  SliceLevel level = root_level();
  for (int number = 0; number < svo.depth; ++number) {
    SparseWalk wide(level);
    const PortableCode portable;
    SparseWalk narrow(level);
    for (std::size_t s = 0; s < level.slice_count(); ++s) {
      wide.visit(s);
      narrow.visit(s);
      for (std::size_t i = 0; i < wide.size(); ++i) {
        ASSERT_EQ(wide.word(i), narrow.word(i));
        ASSERT_EQ(wide.orientation(i), narrow.orientation(i));
      }
    }
    level = next_level(svo, level);
  }
}

TEST(ContextCoder, restores_every_tree_from_one_layer_or_many) {
  for (const Svo& svo : small_trees()) {
    std::vector<int> each(static_cast<std::size_t>(svo.depth));
    for (int i = 0; i < svo.depth; ++i) each[static_cast<std::size_t>(i)] = i + 1;
    for (const std::vector<int>& ends : {std::vector<int>{svo.depth}, each}) {
      const auto masks = decode(svo, encode(svo, ends), ends);
      ASSERT_TRUE(masks) << masks.error().message;
      EXPECT_EQ(*masks, svo.masks);
    }
  }
}

TEST(ContextCoder, writes_and_reads_the_same_bytes_with_and_without_bmi2) {
  for (const Svo& svo : small_trees()) {
    const std::vector<int> ends = {svo.depth};
    const auto fast = encode(svo, ends);
    const PortableCode portable;
    EXPECT_EQ(fast, encode(svo, ends));
    const auto masks = decode(svo, fast, ends);
    ASSERT_TRUE(masks) << masks.error().message;
    EXPECT_EQ(*masks, svo.masks);
  }
}

TEST(ContextCoder, agrees_with_the_reference_decoder) {
  std::ifstream file(source_folder() / "codec/octree/tables/1.zst", std::ios::binary);
  const Bytes tables_file((std::istreambuf_iterator<char>(file)), {});
  const reference::Tables tables1 = reference::read_tables(tables_file);
  std::vector<Svo> trees = small_trees();
  trees.push_back(sheet_tree());
  ASSERT_EQ(level_class(7, trees.back().node_count(7), trees.back().node_count(8)), 5);
  ASSERT_GE(trees.back().node_count(7), 16384u);
  for (const Svo& svo : trees) {
    const int middle = (svo.depth + 1) / 2;
    const std::vector<int> ends =
        middle < svo.depth ? std::vector<int>{middle, svo.depth} : std::vector<int>{svo.depth};
    auto layers = encode(svo, ends);
    layers[0].insert(layers[0].begin(), 1);
    std::vector<reference::ContextLayer> reference;
    int begin = 0;
    for (std::size_t i = 0; i < ends.size(); ++i) {
      reference.push_back({layers[i], begin, ends[i],
                           svo.level_begin[static_cast<std::size_t>(ends[i])] -
                               svo.level_begin[static_cast<std::size_t>(begin)]});
      begin = ends[i];
    }
    const auto masks = reference::decode_context_layers(reference, tables1);
    ASSERT_TRUE(masks) << masks.error().message;
    EXPECT_EQ(*masks, svo.masks);
  }
}

TEST(ContextCoder, reports_a_payload_truncated_at_any_byte) {
  const Svo svo = clustered_tree(6, 300, 4);
  const auto layers = encode(svo, {6});
  for (std::size_t cut = 0; cut < layers[0].size(); ++cut) {
    const Bytes part(layers[0].begin(), layers[0].begin() + static_cast<std::ptrdiff_t>(cut));
    ASSERT_FALSE(decode(svo, {part}, {6})) << cut;
  }
}

TEST(ContextCoder, refuses_sizes_that_differ_from_those_in_the_bytes) {
  const Svo svo = clustered_tree(6, 300, 4);
  const Bytes payload = encode(svo, {6}).front();
  const auto decodes = [&](std::size_t mask_count, std::size_t most_nodes) {
    ContextDecoder decoder(tables());
    Bytes masks;
    return decoder.decode_layer(payload, 0, 6, mask_count, most_nodes, masks).has_value();
  };
  EXPECT_TRUE(decodes(svo.masks.size(), svo.leaf_count()));
  EXPECT_FALSE(decodes(svo.masks.size() - 1, svo.leaf_count()));
  EXPECT_FALSE(decodes(svo.masks.size() + 1, svo.leaf_count()));
  EXPECT_FALSE(decodes(svo.masks.size(), svo.leaf_count() - 1));
  Bytes unknown_class = payload;
  unknown_class[2] = kLevelClasses;
  ContextDecoder decoder(tables());
  Bytes masks;
  EXPECT_FALSE(
      decoder.decode_layer(unknown_class, 0, 6, svo.masks.size(), svo.leaf_count(), masks));
}

/// Tables that are all the same, but for the number of symbols that they store.
std::array<StoredTable, kTables> all_tables(const StoredTable& table) {
  std::array<StoredTable, kTables> tables;
  tables.fill(table);
  return tables;
}

TEST(ContextTables, give_back_what_was_stored) {
  StoredAlphabet one{1, {}}, other{3, {}};
  for (std::size_t s = 0; s < 16; ++s) one.rarity[s] = static_cast<std::uint8_t>(s);
  other.rarity.fill(9);
  const auto parsed =
      parse_tables(write_tables(all_tables({1, {0, 2}, {0, 4, 0}, {one, one, other, one}})));
  ASSERT_TRUE(parsed) << parsed.error().message;
  for (int t = 0; t < kTables; ++t) {
    const ContextTables::Table& table = parsed->tables[static_cast<std::size_t>(t)];
    const auto seen = [&](std::uint64_t word) {
      EXPECT_EQ(parsed->find<PortableExtract>(table, word) / 4, static_cast<unsigned>(t));
      return parsed->alphabets[parsed->find<PortableExtract>(table, word)].seen();
    };
    EXPECT_EQ(seen(0b000), 11);
    EXPECT_EQ(seen(0b001), 11);
    EXPECT_EQ(seen(0b101), 57);
    EXPECT_EQ(seen(0b011), 11);
    const Alphabet16& first = parsed->alphabets[parsed->find<PortableExtract>(table, 0)];
    EXPECT_GT(first.range(0).size, 3 * first.range(6).size);
    EXPECT_EQ(first.range(15).size > 4, symbols_of_table(t) == 16);
  }
}

TEST(ContextTables, store_a_share_as_the_nearest_rarity) {
  EXPECT_EQ(rarity_of(1.0), 0);
  EXPECT_EQ(rarity_of(0.0), 15);
  for (double share = 1.0; share > 1e-4; share *= 0.7) {
    EXPECT_LE(rarity_of(share), rarity_of(0.7 * share));
  }
}

TEST(ContextTables, are_refused_if_they_are_damaged) {
  Bytes bytes = write_tables(all_tables({0, {0}, {0}, {{}}}));
  ASSERT_TRUE(parse_tables(bytes));
  for (std::size_t cut = 0; cut < bytes.size(); ++cut) {
    EXPECT_FALSE(parse_tables(ByteView(bytes).first(cut))) << cut;
  }
  bytes.push_back(0);
  EXPECT_FALSE(parse_tables(bytes)) << "one byte too many";
  bytes.pop_back();
  bytes[7] = 0x80;  // bit 63 of a mask
  EXPECT_FALSE(parse_tables(bytes));
  bytes[7] = 0x10;  // more than the bits of a word
  EXPECT_FALSE(parse_tables(bytes));
  std::fill(bytes.begin(), bytes.begin() + 4, std::uint8_t{0xff});
  bytes[7] = 0;  // 2^32 cells
  EXPECT_FALSE(parse_tables(bytes));
}

TEST(ContextTables, package_tables_fall_back_to_built_in_tables_that_they_lack) {
  auto stored = all_tables({kBaseTable, {}, {}, {}});
  constexpr std::size_t kOwn = 4;
  StoredAlphabet even{2, {}};
  stored[kOwn] = {0b101, {0, 0b10, 0, 0}, {0, 0, 0, 0b1000, 0}, {even, even, even, {}, even, even}};
  const auto file = write_table_file(write_tables(stored));
  ASSERT_TRUE(file) << file.error().message;
  const auto tables_of_file = read_table_file(*file);
  ASSERT_TRUE(tables_of_file) << tables_of_file.error().message;
  const ContextTables &merged = **tables_of_file, &base = *tables();
  EXPECT_EQ(merged.checksum, XXH3_64bits(file->data(), file->size()));
  std::mt19937_64 random(1);
  for (std::size_t t = 0; t < kTables; ++t) {
    if (t == kOwn) {
      const auto seen = [&](std::uint64_t word) {
        return merged.alphabets[merged.find<PortableExtract>(merged.tables[t], word)].seen();
      };
      EXPECT_EQ(seen(0), 25);
      EXPECT_EQ(seen(0b0011), 25);
      EXPECT_EQ(seen(0b0100), 5);
      EXPECT_EQ(seen(0b1100), 25);
      continue;
    }
    for (int i = 0; i < 1000; ++i) {
      const std::uint64_t word = random() >> 4;
      const Alphabet16& mine =
          merged.alphabets[merged.find<PortableExtract>(merged.tables[t], word)];
      const Alphabet16& theirs = base.alphabets[base.find<PortableExtract>(base.tables[t], word)];
      ASSERT_EQ(mine.range(1).size, theirs.range(1).size);
      ASSERT_EQ(mine.range(5).begin, theirs.range(5).begin);
    }
  }
}

TEST(ContextTables, package_tables_are_refused_if_they_are_damaged) {
  const auto file = write_table_file(write_tables(all_tables({1, {0, 0}, {0, 0}, {{}, {}}})));
  ASSERT_TRUE(file && read_table_file(*file));
  for (std::size_t cut = 0; cut < file->size(); ++cut) {
    EXPECT_FALSE(read_table_file(ByteView(*file).first(cut))) << cut;
  }
  Bytes other = *file;
  other.front() = kNewestTables + 1;
  EXPECT_FALSE(read_table_file(other)) << "the file is based on unknown tables";
  other = *file;
  other.resize(kMaxTablesBytes + 1);
  EXPECT_FALSE(read_table_file(other));
  const auto huge = write_table_file(Bytes((std::size_t{1} << 22) + 1));
  EXPECT_FALSE(read_table_file(*huge)) << "the file unpacks to more than the limit";
  EXPECT_FALSE(parse_tables(write_tables(all_tables({kBaseTable, {}, {}, {}}))))
      << "there is no base";
}

#if defined(__x86_64__)
TEST(ContextTables, find_the_same_alphabets_with_and_without_bmi2) {
  if ((cpu_features() & kCpuBmi2) == 0) GTEST_SKIP();
  std::mt19937_64 random(1);
  const auto all = tables();
  for (int i = 0; i < 10000; ++i) {
    const std::uint64_t word = random() >> 4;
    for (const ContextTables::Table& table : all->tables) {
      ASSERT_EQ(all->find<PortableExtract>(table, word), all->find<HardwareExtract>(table, word));
    }
  }
}
#endif

TEST(ContextTables, are_refused_if_their_number_is_unknown) {
  EXPECT_FALSE(tables_of_number(0));
  EXPECT_FALSE(tables_of_number(kNewestTables + 1));
}

}  // namespace
}  // namespace pointreel::context_coder_test
