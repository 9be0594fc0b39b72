#include "codec/training/sequence_tables.h"

#include <fstream>
#include <iterator>
#include <memory>
#include <random>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "codec/core/build.h"
#include "codec/core/morton.h"
#include "codec/octree/context_coder.h"
#include "codec/octree/context_tables.h"
#include "tests/paths.h"
#include "tests/reference/context_decoder.h"

namespace pointreel::sequence_tables_test {
namespace {

/// Cells in pairs at a fixed offset, which no surface has, so that there is something to learn.
Svo patterned_tree(int depth, std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  const std::uint32_t side = 1u << depth;
  SortedPoints sorted;
  sorted.levels = depth;
  for (std::uint32_t i = 0; i < count; ++i) {
    const glm::uvec3 at(random() % side, random() % side, (random() % 8) * (side / 8));
    for (const std::uint32_t step : {0u, 3u}) {
      sorted.points.push_back({morton_encode((at + step) % side), 2 * i + step});
    }
  }
  std::sort(sorted.points.begin(), sorted.points.end(),
            [](const KeyIndex& a, const KeyIndex& b) { return a.key < b.key; });
  return build_svo(sorted, depth);
}

std::vector<Svo> patterned_trees(unsigned count) {
  std::vector<Svo> trees;
  for (unsigned i = 0; i < count; ++i) trees.push_back(patterned_tree(6, 1000, i));
  return trees;
}

Bytes coded(const Svo& svo, std::shared_ptr<const ContextTables> tables) {
  ContextEncoder encoder(std::move(tables));
  Bytes payload;
  encoder.encode_layer(svo, 0, svo.depth, payload);
  return payload;
}

double coded_bytes(const std::vector<Svo>& trees,
                   const std::shared_ptr<const ContextTables>& tables) {
  double bytes = 0.0;
  for (const Svo& svo : trees) bytes += static_cast<double>(coded(svo, tables).size());
  return bytes;
}

TEST(SequenceTables, save_as_much_as_predicted_if_they_learn_from_all_frames) {
  const std::vector<Svo> trees = patterned_trees(12);
  const auto learnt = learn_tables(trees, trees.size());
  ASSERT_TRUE(learnt) << learnt.error().message;
  ASSERT_FALSE(learnt->file.empty());
  const double before = coded_bytes(trees, tables_of_number(kNewestTables).value());
  const double after = coded_bytes(trees, read_table_file(learnt->file).value()) +
                       static_cast<double>(learnt->file.size() + 8 * trees.size());
  EXPECT_LT(after, 0.9 * before);
  EXPECT_NEAR(before - after, learnt->saved_bytes, 0.005 * before);
}

TEST(SequenceTables, save_more_in_a_longer_sequence) {
  const std::vector<Svo> trees = patterned_trees(6);
  const auto few = learn_tables(trees, 6), many = learn_tables(trees, 100);
  ASSERT_TRUE(few && many);
  EXPECT_GT(many->saved_bytes / 100, few->saved_bytes / 6);
}

TEST(SequenceTables, are_not_written_if_they_would_not_pay_off) {
  const std::vector<Svo> tiny = {patterned_tree(3, 2, 1)};
  EXPECT_TRUE(learn_tables(tiny, 1)->file.empty());
  EXPECT_TRUE(learn_tables(tiny, 100)->file.empty()) << "one frame alone cannot be cross-checked";
  EXPECT_TRUE(learn_tables({}, 0)->file.empty());
  const std::vector<Svo> empty(2);
  EXPECT_TRUE(learn_tables(empty, 2)->file.empty());
}

TEST(SequenceTables, are_the_same_on_any_number_of_threads) {
  const std::vector<Svo> trees = patterned_trees(3);
  const auto one = [&] {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    return learn_tables(trees, 9)->file;
  }();
  EXPECT_FALSE(one.empty());
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 4);
  EXPECT_EQ(learn_tables(trees, 9)->file, one);
}

TEST(SequenceTables, are_read_alike_by_the_reference_decoder) {
  std::ifstream in(source_folder() / "codec/octree/tables/1.zst", std::ios::binary);
  const Bytes tables_file((std::istreambuf_iterator<char>(in)), {});
  const std::vector<Svo> trees = patterned_trees(8);
  const Bytes file = learn_tables(trees, 8)->file;
  ASSERT_FALSE(file.empty());
  Bytes payload = {kGivenTables, 0, 0, 0, 0, 0, 0, 0, 0};
  const Bytes masks = coded(trees[0], read_table_file(file).value());
  payload.insert(payload.end(), masks.begin(), masks.end());
  const reference::Tables tables1 = reference::read_tables(tables_file);
  const reference::Tables own = reference::read_package_tables(file, tables1);
  const auto decoded = reference::decode_context_layers(
      {{payload, 0, trees[0].depth, trees[0].masks.size()}}, tables1, &own);
  ASSERT_TRUE(decoded) << decoded.error().message;
  EXPECT_EQ(*decoded, trees[0].masks);
}

}  // namespace
}  // namespace pointreel::sequence_tables_test
