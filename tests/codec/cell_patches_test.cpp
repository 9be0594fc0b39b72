#include "codec/mesh/cell_patches.h"

#include <gtest/gtest.h>

namespace pointreel::cell_patches_test {
namespace {

TEST(CellPatches, have_every_crossed_edge_once) {
  for (int inside = 0; inside < 256; ++inside) {
    const CellPatches& patches = cell_patches(static_cast<std::uint8_t>(inside));
    for (int edge = 0; edge < 12; ++edge) {
      const auto [a, b] = edge_corners(edge);
      const bool crossed = (inside >> a & 1) != (inside >> b & 1);
      EXPECT_EQ(crossed, patches.of[edge] != CellPatches::kNone) << inside << " " << edge;
      EXPECT_LT(crossed ? patches.of[edge] : 0, crossed ? patches.count : 1);
    }
  }
}

TEST(CellPatches, keep_diagonal_corners_inside_apart) {
  EXPECT_EQ(cell_patches(0b00000001).count, 1);
  EXPECT_EQ(cell_patches(0b00001001).count, 2) << "two corners on the diagonal of a face";
  EXPECT_EQ(cell_patches(0b10000001).count, 2) << "two opposite corners";
  EXPECT_EQ(cell_patches(0b01101001).count, 4) << "a tetrahedron of corners";
  EXPECT_EQ(cell_patches(0b00001111).count, 1);
  EXPECT_EQ(cell_patches(0b00000000).count, 0);
}

TEST(CellPatches, have_at_least_three_edges_each) {
  for (int inside = 1; inside < 255; ++inside) {
    const CellPatches& patches = cell_patches(static_cast<std::uint8_t>(inside));
    for (int patch = 0; patch < patches.count; ++patch) {
      int edges = 0;
      for (const std::uint8_t of : patches.of) edges += of == patch ? 1 : 0;
      EXPECT_GE(edges, 3) << inside;
    }
  }
}

}  // namespace
}  // namespace pointreel::cell_patches_test
