#include "codec/octree/context_coder.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <memory>
#include <random>

#include <gtest/gtest.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "codec/octree/context_tables.h"
#include "pointreel/octree.h"
#include "pointreel/package.h"
#include "tests/portable_code.h"
#include "tests/reference/context_decoder.h"
#include "tests/unit/tree_of_cells.h"

namespace pointreel {
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

TEST(RasterWalk, finds_the_same_neighbours_by_planes_as_by_searching) {
  for (const Svo& svo :
       {shell_tree(5, 4), clustered_tree(7, 3000, 1), clustered_tree(9, 2000, 2)}) {
    RasterLevel level = root_level();
    for (int number = 0; number < svo.depth; ++number) {
      const std::size_t begin = svo.level_begin[static_cast<std::size_t>(number)];
      std::vector<std::uint32_t> first_child(level.size());
      Bytes masks(level.size());
      for (std::size_t i = 0; i < level.size(); ++i) {
        masks[i] = svo.masks[begin + level.rank[i]];
        first_child[i] =
            svo.first_child[begin + i] - svo.level_begin[static_cast<std::size_t>(number) + 1];
      }
      std::vector<std::uint64_t> by_planes, by_searching;
      SliceWalk<PlaneNeighbors>(level).visit(kAllNodes,
                                             [&](std::uint32_t node, std::uint64_t word) {
                                               by_planes.push_back(word);
                                               return std::uint32_t{masks[node]};
                                             });
      std::fill(level.masks.begin(), level.masks.end(), std::uint8_t{0});
      SliceWalk<SearchNeighbors>(level).visit(kAllNodes,
                                              [&](std::uint32_t node, std::uint64_t word) {
                                                by_searching.push_back(word);
                                                return std::uint32_t{masks[node]};
                                              });
      ASSERT_EQ(by_planes, by_searching) << "level " << number;
      std::vector<std::uint64_t> known_by_planes, known_by_searching;
      SliceWalk<PlaneNeighbors>(level).visit_known(kAllNodes, [&](std::uint32_t, auto words) {
        known_by_planes.insert(known_by_planes.end(), words.begin(), words.end());
      });
      SliceWalk<SearchNeighbors>(level).visit_known(kAllNodes, [&](std::uint32_t, auto words) {
        known_by_searching.insert(known_by_searching.end(), words.begin(), words.end());
      });
      ASSERT_EQ(by_planes, known_by_planes) << "level " << number;
      ASSERT_EQ(by_planes, known_by_searching) << "level " << number;
      ASSERT_EQ(level.masks, masks);
      RasterLevel below;
      expand(level, first_child, svo.node_count(number + 1), below);
      level = std::move(below);
    }
    EXPECT_EQ(level.size(), svo.leaf_count());
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
  std::ifstream file(POINTREEL_SOURCE_DIR "/codec/octree/tables/1.zst", std::ios::binary);
  const Bytes tables_file((std::istreambuf_iterator<char>(file)), {});
  const reference::Tables tables1 = reference::read_tables(tables_file);
  std::vector<Svo> trees = small_trees();
  trees.push_back(sheet_tree());
  ASSERT_EQ(level_class(trees.back().node_count(7), trees.back().node_count(8)), 5);
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

std::array<SlotTables, kLevelClasses * kSlots> all_slots(const SlotTables& slot) {
  std::array<SlotTables, kLevelClasses * kSlots> slots;
  slots.fill(slot);
  return slots;
}

TEST(ContextTables, are_refused_if_they_are_damaged) {
  Bytes bytes = write_tables(all_slots({0, {0}, {0x80}}));
  ASSERT_TRUE(parse_tables(bytes));
  for (std::size_t cut = 0; cut < bytes.size(); ++cut) {
    EXPECT_FALSE(parse_tables(ByteView(bytes).first(cut))) << cut;
  }
  bytes.push_back(0);
  EXPECT_FALSE(parse_tables(bytes)) << "one leaf too many";
  bytes.pop_back();
  bytes[7] = 0x80;  // bit 63 of a mask
  EXPECT_FALSE(parse_tables(bytes));
  std::fill(bytes.begin(), bytes.begin() + 7, std::uint8_t{0xff});
  bytes[7] = 0x7f;  // 2^63 cells
  EXPECT_FALSE(parse_tables(bytes));
}

TEST(ContextTables, package_tables_fall_back_to_built_in_slots_that_they_lack) {
  auto slots = all_slots({kBaseSlot, {}, {}});
  slots[kSlots + 3] = {0b101, {0, 0b10, 0, 0}, {4, 8, 12, 16, 20}};
  const auto file = write_table_file(write_tables(slots));
  ASSERT_TRUE(file) << file.error().message;
  const auto tables_of_file = read_table_file(*file);
  ASSERT_TRUE(tables_of_file) << tables_of_file.error().message;
  const ContextTables &merged = **tables_of_file, &base = *tables();
  EXPECT_EQ(merged.checksum, XXH3_64bits(file->data(), file->size()));
  for (std::size_t c = 0; c < kLevelClasses; ++c) {
    for (std::size_t s = 0; s < kSlots; ++s) {
      const auto &mine = merged.slots[c][s], &theirs = base.slots[c][s];
      if (c == 1 && s == 3) {
        EXPECT_EQ(mine.mask, 0b101u);
        const auto& cell = merged.cells[mine.first_cell + 1];
        EXPECT_EQ(cell.mask, 0b10u);
        EXPECT_EQ(merged.leaves[cell.first_leaf + 1].probability, unpack_leaf(12).probability);
        continue;
      }
      ASSERT_EQ(mine.mask, theirs.mask);
      const std::uint32_t last = (1u << std::popcount(mine.mask)) - 1;
      const auto &my_cell = merged.cells[mine.first_cell + last],
                 &their_cell = base.cells[theirs.first_cell + last];
      ASSERT_EQ(my_cell.mask, their_cell.mask);
      ASSERT_EQ(merged.leaves[my_cell.first_leaf].probability,
                base.leaves[their_cell.first_leaf].probability);
    }
  }
}

TEST(ContextTables, package_tables_are_refused_if_they_are_damaged) {
  const auto file = write_table_file(write_tables(all_slots({0b1, {0, 0}, {0x80, 0x81}})));
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
  EXPECT_FALSE(parse_tables(write_tables(all_slots({kBaseSlot, {}, {}})))) << "there is no base";
}

TEST(ContextTables, are_refused_if_their_number_is_unknown) {
  EXPECT_FALSE(tables_of_number(0));
  EXPECT_FALSE(tables_of_number(kNewestTables + 1));
}

}  // namespace
}  // namespace pointreel
