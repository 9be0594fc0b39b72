#include <algorithm>
#include <fstream>
#include <iterator>
#include <memory>
#include <random>
#include <thread>

#include <gtest/gtest.h>
#include <malloc.h>

#include "codec/octree/context_coder.h"
#include "codec/octree/context_tables.h"
#include "codec/octree/octree_codec.h"
#include "tests/paths.h"
#include "tests/portable_code.h"
#include "tests/reference/context_decoder.h"
#include "tests/tree_of_cells.h"

namespace pointreel::slabs_test {
namespace {

/// Runs each call in a thread of its own, started in reverse order.
void on_threads(int count, const std::function<void(int)>& body) {
  std::vector<std::thread> threads;
  for (int i = count; i-- > 0;) threads.emplace_back(body, i);
  for (std::thread& thread : threads) thread.join();
}

/// Curved sheets with three cells for each place of a plane. `longest` selects its longer side.
Svo sheets(int depth, int longest) {
  const std::uint32_t side = 1u << depth;
  std::vector<glm::uvec3> cells;
  for (std::uint32_t i = 0; i < side; ++i) {
    for (std::uint32_t j = 0; j < side * 3 / 4; ++j) {
      for (std::uint32_t sheet = 1; sheet < 4; ++sheet) {
        const std::uint32_t x = side * sheet / 5 + (i * i + i * j) / (12 * side);
        cells.push_back(longest == 1 ? glm::uvec3(x, i, j) : glm::uvec3(x, j, i));
      }
    }
  }
  return tree_of_cells(cells, depth);
}

/// Cells far apart, on levels whose bit planes would be too large.
Svo sparse_tree(int depth, std::size_t count) {
  std::mt19937 random(1);
  std::vector<glm::uvec3> cells(count);
  for (glm::uvec3& cell : cells) {
    cell = glm::uvec3(random(), random(), random()) >> static_cast<unsigned>(32 - depth);
  }
  return tree_of_cells(cells, depth);
}

std::shared_ptr<const ContextTables> tables() { return tables_of_number(1).value(); }

std::size_t masks_of_layer(const Svo& svo, int begin, int end) {
  return svo.level_begin[static_cast<std::size_t>(end)] -
         svo.level_begin[static_cast<std::size_t>(begin)];
}

std::vector<Bytes> encode(const Svo& svo, const std::vector<int>& ends, int slabs,
                          const Executor& executor = {}) {
  ContextEncoder encoder(tables(), slabs);
  std::vector<Bytes> layers;
  int begin = 0;
  for (const int end : ends) {
    encoder.encode_layer(svo, begin, end, layers.emplace_back(), executor);
    begin = end;
  }
  return layers;
}

Result<Bytes> decode(const Svo& svo, const std::vector<Bytes>& layers, const std::vector<int>& ends,
                     const Executor& executor = {}) {
  ContextDecoder decoder(tables());
  Bytes masks;
  int begin = 0;
  for (std::size_t i = 0; i < layers.size(); ++i) {
    // The buffer ends with the payload, so that reads past the end are noticed.
    const auto exact = std::make_unique<std::uint8_t[]>(layers[i].size());
    std::copy(layers[i].begin(), layers[i].end(), exact.get());
    const auto done = decoder.decode_layer({exact.get(), layers[i].size()}, begin, ends[i],
                                           masks_of_layer(svo, begin, ends[i]), svo.leaf_count(),
                                           masks, executor);
    if (!done) return tl::unexpected(done.error());
    begin = ends[i];
  }
  return masks;
}

TEST(Slabs, restore_every_tree_and_give_the_same_bytes_on_any_number_of_threads) {
  for (const Svo& svo : {sheets(7, 1), sheets(7, 2), sparse_tree(14, 3000)}) {
    for (const std::vector<int>& ends : {std::vector<int>{3, svo.depth}, {3, 6, svo.depth}}) {
      std::size_t size_of_one = 0;
      for (const int slabs : {1, 2, 3}) {
        const auto layers = encode(svo, ends, slabs);
        EXPECT_EQ(layers, encode(svo, ends, slabs, on_threads));
        for (const Executor& executor : {Executor{}, Executor{on_threads}}) {
          const auto masks = decode(svo, layers, ends, executor);
          ASSERT_TRUE(masks) << masks.error().message;
          EXPECT_EQ(*masks, svo.masks);
        }
        // The last layer begins with the classes of its levels, followed by the number of slabs.
        const int begin = ends[ends.size() - 2];
        const std::size_t most = masks_of_layer(svo, begin, svo.depth) / kLeastMasksOfSlab;
        EXPECT_EQ(layers.back()[static_cast<std::size_t>(svo.depth - begin)],
                  std::min(most, static_cast<std::size_t>(slabs)));
        if (slabs == 1) size_of_one = layers.back().size();
        EXPECT_LT(layers.back().size(), size_of_one + size_of_one / 3);
      }
    }
  }
}

TEST(Slabs, give_the_same_bytes_with_and_without_bmi2) {
  const Svo svo = sheets(7, 1);
  const auto fast = encode(svo, {3, 7}, 3);
  const PortableCode portable;
  EXPECT_EQ(encode(svo, {3, 7}, 3), fast);
}

TEST(Slabs, agree_with_the_reference_decoder) {
  std::ifstream file(source_folder() / "codec/octree/tables/1.zst", std::ios::binary);
  const Bytes tables_file((std::istreambuf_iterator<char>(file)), {});
  const std::vector<int> ends = {3, 6, 7};
  for (const int longest : {1, 2}) {
    const Svo svo = sheets(7, longest);
    auto layers = encode(svo, ends, 2 + longest);
    layers[0].insert(layers[0].begin(), 1);
    std::vector<reference::ContextLayer> reference;
    for (std::size_t i = 0; i < ends.size(); ++i) {
      const int begin = i == 0 ? 0 : ends[i - 1];
      reference.push_back({layers[i], begin, ends[i], masks_of_layer(svo, begin, ends[i])});
    }
    const auto masks =
        reference::decode_context_layers(reference, reference::read_tables(tables_file));
    ASSERT_TRUE(masks) << masks.error().message;
    EXPECT_TRUE(*masks == svo.masks);
  }
}

TEST(Slabs, divide_the_frame_into_about_equal_shares) {
  const Svo svo = sheets(8, 2);
  const auto layers = encode(svo, {7, 8}, 4);
  // One level's class, the number of slabs, and where three of them begin.
  ASSERT_EQ(layers[1][1], 4);
  for (std::size_t slab = 1; slab < 4; ++slab) {
    EXPECT_NEAR(layers[1][2 * slab], 32.0 * static_cast<double>(slab), 3.0);
    EXPECT_EQ(layers[1][2 * slab + 1], 0);
  }
}

TEST(Slabs, have_a_default_number_that_depends_only_on_the_leaves) {
  EXPECT_EQ(default_slabs(0), 1);
  EXPECT_EQ(default_slabs((1u << 20) - 1), 1);
  EXPECT_EQ(default_slabs(1u << 20), 2);
  EXPECT_EQ(default_slabs(1u << 30), kMostSlabs);
}

/// Layers that end at levels 3 and 7. The second has three slabs.
struct Forged {
  Svo svo = sheets(7, 1);
  std::vector<Bytes> layers = encode(svo, {3, 7}, 3);
  /// Where the slabs of the second layer begin: their number, two u16 and two u32.
  static constexpr std::size_t kHeader = 4, kSize = 1 + 2 * 2 + 2 * 4;

  bool decodes() const { return decode(svo, layers, {3, 7}).has_value(); }
  bool decodes_with(std::size_t at, std::uint8_t value) const {
    Forged changed = *this;
    changed.layers[1][kHeader + at] = value;
    return changed.decodes();
  }
};

TEST(Slabs, are_refused_if_their_number_or_begin_is_invalid) {
  const Forged good;
  ASSERT_TRUE(good.decodes());
  for (const int number : {0, 1, 2, 4, 5, 17, 255}) {
    EXPECT_FALSE(good.decodes_with(0, static_cast<std::uint8_t>(number))) << number;
  }
  const std::uint8_t second = good.layers[1][Forged::kHeader + 3];
  EXPECT_FALSE(good.decodes_with(1, 0)) << "the first slab is empty";
  EXPECT_FALSE(good.decodes_with(1, second)) << "the slabs are not in order";
  EXPECT_FALSE(good.decodes_with(3, 8)) << "a slab lies outside the level";
  EXPECT_FALSE(good.decodes_with(4, 1)) << "a slab lies outside the level";
  EXPECT_FALSE(good.decodes_with(7, 1)) << "a slab is longer than the payload";
  EXPECT_FALSE(good.decodes_with(12, 0x80)) << "a slab is longer than the payload";
}

TEST(Slabs, stay_the_same_in_all_layers_after_the_first) {
  const Svo svo = sheets(7, 2);
  const std::vector<int> ends = {3, 6, 7};
  auto layers = encode(svo, ends, 1);
  const auto parted = encode(svo, ends, 2);
  ASSERT_EQ(parted[2][1], 2);
  ASSERT_EQ(parted[1][3], 1) << "there are too few masks for slabs";
  ASSERT_TRUE(decode(svo, parted, ends));
  EXPECT_FALSE(
      decode(svo, {layers[0], layers[1], Bytes(parted[2].begin(), parted[2].end() - 9)}, ends));
  const Svo deep = sheets(8, 2);
  const std::vector<int> deep_ends = {3, 7, 8};
  auto three = encode(deep, deep_ends, 3);
  ASSERT_EQ(three[1][4], 3);
  ASSERT_EQ(three[2][1], 3);
  for (const int number : {0, 1, 2, 4}) {
    three[2][1] = static_cast<std::uint8_t>(number);
    EXPECT_FALSE(decode(deep, three, deep_ends)) << number;
  }
}

TEST(Slabs, do_no_harm_if_truncated_or_changed_in_any_byte_of_the_header) {
  const Forged good;
  const Bytes whole = good.layers[1];
  for (std::size_t cut = 0; cut < whole.size(); cut += cut < 40 ? 1 : 97) {
    Forged changed = good;
    changed.layers[1].resize(cut);
    EXPECT_FALSE(changed.decodes()) << cut;
  }
  for (std::size_t at = 0; at < Forged::kSize; ++at) {
    for (const int change : {1, 2, 16, 128, 255}) {
      const auto value = static_cast<std::uint8_t>(whole[Forged::kHeader + at] ^ change);
      EXPECT_FALSE(good.decodes_with(at, value)) << at << " changed by " << change;
    }
  }
}

/// The bytes in use on the heap if the allocator tells, otherwise 0.
std::size_t heap_in_use() {
  const auto info = mallinfo2();
  return info.uordblks + info.hblkhd;
}

TEST(Slabs, use_no_more_memory_than_their_header_states) {
  const Svo svo = sheets(8, 1);
  const std::vector<int> ends = {3, 7, 8};
  const std::size_t finest = svo.node_count(7) + svo.node_count(6);
  for (const int slabs : {1, 4}) {
    const auto layers = encode(svo, ends, slabs);
    const std::size_t before = heap_in_use();
    std::size_t most = before;
    const Executor noting = [&](int count, const std::function<void(int)>& body) {
      for (int i = 0; i < count; ++i) {
        body(i);
        most = std::max(most, heap_in_use());
      }
    };
    ASSERT_TRUE(decode(svo, layers, ends, noting));
    const std::size_t of_alphabets =
        static_cast<std::size_t>(slabs + 1) * tables()->alphabets.size() * sizeof(Alphabet16);
    EXPECT_LT(most - before, 170 * finest + of_alphabets + 65536 * static_cast<std::size_t>(slabs));
  }
}

TEST(OctreeCodec, decodes_the_same_from_any_number_of_slabs_and_threads) {
  PointCloud cloud;
  for (int i = 0; i < 200; ++i) {
    for (int j = 0; j < 200; ++j) {
      const glm::vec3 p(static_cast<float>(i), static_cast<float>(j),
                        static_cast<float>((i * i + j * j) % 90));
      cloud.positions.push_back((p + 0.5f) / 256.0f);
    }
  }
  OctreeOptions options{Entropy::context, DepthRule::fixed(9)};
  Bytes masks;
  for (const int slabs : {1, 2, 5}) {
    options.slabs = slabs;
    const auto serial = encode_octree(cloud, Cube{}, options, false, false);
    const auto frame = encode_octree(cloud, Cube{}, options, false, false, on_threads);
    ASSERT_TRUE(serial && frame);
    for (std::size_t layer = 0; layer < frame->layers.size(); ++layer) {
      EXPECT_EQ(frame->layers[layer].geometry, serial->layers[layer].geometry);
    }
    DecodeLimits limits;
    limits.executor = on_threads;
    const auto tree = decode_octree_tree(layer_views(frame->layers), limits);
    ASSERT_TRUE(tree) << tree.error().message;
    if (masks.empty()) masks = tree->svo.masks;
    EXPECT_EQ(tree->svo.masks, masks);
  }
  options.slabs = kMostSlabs + 1;
  EXPECT_FALSE(encode_octree(cloud, Cube{}, options, false, false));
}

}  // namespace
}  // namespace pointreel::slabs_test
