#include "codec/octree/raster_walk.h"

#include <algorithm>

namespace pointreel {

RasterLevel root_level() {
  RasterLevel root;
  root.rows = {{0, 0, 0}, {0, 0, 1}};
  root.x = {0};
  root.rank = {0};
  root.masks = {0};
  root.around = {0};
  root.parents = {0};
  return root;
}

void expand(const RasterLevel& level, std::span<const std::uint32_t> first_child,
            std::size_t child_count, RasterLevel& children) {
  children.level = level.level + 1;
  children.slab = {level.slab.axis, 2 * level.slab.begin, 2 * level.slab.end};
  children.rows.clear();
  // With two spare entries, because both children of a node in a row are always written.
  children.x.resize(child_count + 2);
  children.rank.resize(child_count + 2);
  children.parents.resize(child_count + 2);
  std::vector<std::uint32_t> first(level.size());
  for (std::size_t i = 0; i < first.size(); ++i) first[i] = first_child[level.rank[i]];
  std::uint32_t* x = children.x.data();
  std::uint32_t* rank = children.rank.data();
  std::uint32_t* parents = children.parents.data();
  std::uint32_t count = 0;
  const std::size_t rows = level.rows.size() - 1;
  for (std::size_t slice = 0, end; slice < rows; slice = end) {
    const std::uint32_t z = level.rows[slice].z;
    end = slice + 1;
    while (end < rows && level.rows[end].z == z) ++end;
    for (std::uint32_t dz = 0; dz < 2; ++dz) {
      for (std::size_t r = slice; r < end; ++r) {
        const RasterLevel::Row& row = level.rows[r];
        for (std::uint32_t dy = 0; dy < 2; ++dy) {
          const std::uint32_t shift = 4 * dz + 2 * dy, begin = count;
          const std::uint32_t earlier = (1u << shift) - 1;
          for (std::uint32_t i = row.begin; i < level.rows[r + 1].begin; ++i) {
            const std::uint32_t mask = level.masks[i], left = mask >> shift & 1u;
            const std::uint32_t child =
                first[i] + static_cast<std::uint32_t>(std::popcount(mask & earlier));
            x[count] = 2 * level.x[i];
            parents[count] = level.around[i] | shift << 26;
            rank[count] = child;
            count += left;
            x[count] = 2 * level.x[i] + 1;
            parents[count] = level.around[i] | (shift + 1) << 26;
            rank[count] = child + left;
            count += mask >> (shift + 1) & 1u;
          }
          if (count > begin) children.rows.push_back({2 * row.y + dy, 2 * z + dz, begin});
        }
      }
    }
  }
  children.rows.push_back({0, 0, count});
  children.x.resize(child_count);
  children.rank.resize(child_count);
  children.parents.resize(child_count);
  children.around.resize(child_count);
  children.masks.assign(child_count, 0);
}

RowRange rows_in_slab(const RasterLevel& level, std::size_t begin, std::size_t end) {
  const RasterLevel::Slab& slab = level.slab;
  if (slab.axis == 2) {
    const std::uint32_t z = level.rows[begin].z;
    return {z >= slab.begin && z < slab.end ? begin : end, end};
  }
  while (begin < end && level.rows[begin].y < slab.begin) ++begin;
  while (begin < end && level.rows[end - 1].y >= slab.end) --end;
  return {begin, end};
}

// --- Bit planes ---

PlaneNeighbors::PlaneNeighbors(const RasterLevel& level) : level_(level) {
  const std::size_t side = std::size_t{1} << level.level;
  node_stride_ = side / 8 + 4;
  cell_stride_ = 2 * side / 8 + 4;
  const std::size_t nodes = node_stride_ * (side + 3), cells = cell_stride_ * (2 * side + 3);
  bytes_.assign(3 * nodes + 3 * cells, 0);
  std::uint8_t* next = bytes_.data();
  for (std::uint8_t** plane : {&nodes_before_, &nodes_, &nodes_after_}) {
    *plane = next;
    next += nodes;
  }
  for (std::uint8_t** plane : {&cells_below_, &cells_near_, &cells_far_}) {
    *plane = next;
    next += cells;
  }
}

PlaneNeighbors::Rows PlaneNeighbors::next_slice(Rows rows) const {
  const std::size_t last = level_.rows.size() - 1;
  Rows next{rows.end, rows.end};
  const std::uint32_t z = level_.rows[rows.begin].z + 1;
  while (next.end < last && level_.rows[next.end].z == z) ++next.end;
  return next;
}

void PlaneNeighbors::begin_slice(std::size_t first_row, std::size_t end_row) {
  // This slice is already marked if the one before was next to it.
  slice_ = {first_row, end_row};
  if (after_.begin == after_.end) mark(nodes_, slice_);
  after_ = next_slice(slice_);
  mark(nodes_after_, after_);
}

void PlaneNeighbors::end_slice() {
  clear_nodes(nodes_before_, before_);
  clear_cells(cells_below_, before_);
  clear_cells(cells_near_, slice_);
  if (after_.begin == after_.end) {
    clear_nodes(nodes_, slice_);
    clear_cells(cells_far_, slice_);
    before_ = {};
    return;
  }
  std::swap(nodes_before_, nodes_);
  std::swap(nodes_, nodes_after_);
  std::swap(cells_below_, cells_far_);
  before_ = slice_;
}

PlaneNeighbors::Row PlaneNeighbors::row(std::size_t number) {
  const std::size_t node_row = level_.rows[number].y * node_stride_;
  const std::size_t cell_row = 2 * level_.rows[number].y * cell_stride_;
  Row row;
  row.below_ = cells_below_ + cell_row;
  row.near_above_ = cells_near_ + cell_row;
  row.far_above_ = cells_far_ + cell_row;
  row.nodes_ = {nodes_before_ + node_row, nodes_ + node_row, nodes_after_ + node_row};
  row.near_ = cells_near_ + cell_row + cell_stride_;
  row.far_ = cells_far_ + cell_row + cell_stride_;
  row.cell_stride_ = cell_stride_;
  row.node_stride_ = node_stride_;
  return row;
}

void PlaneNeighbors::mark(std::uint8_t* plane, Rows rows) {
  for (std::size_t r = rows.begin; r < rows.end; ++r) {
    std::uint8_t* row = plane + (level_.rows[r].y + 1) * node_stride_;
    const std::uint32_t end = level_.rows[r + 1].begin;
    for (std::uint32_t i = level_.rows[r].begin; i < end; ++i) {
      const std::uint32_t at = level_.x[i] + kMargin;
      row[at / 8] = static_cast<std::uint8_t>(row[at / 8] | 1u << at % 8);
    }
  }
}

// Rows are usually short, so that clearing them byte by byte is faster than calling memset.
void PlaneNeighbors::clear_nodes(std::uint8_t* plane, Rows rows) {
  for (std::size_t r = rows.begin; r < rows.end; ++r) {
    std::uint8_t* row = plane + (level_.rows[r].y + 1) * node_stride_;
    const std::uint32_t end = level_.rows[r + 1].begin;
    for (std::uint32_t i = level_.rows[r].begin; i < end; ++i) row[(level_.x[i] + kMargin) / 8] = 0;
  }
}

void PlaneNeighbors::clear_cells(std::uint8_t* plane, Rows rows) {
  for (std::size_t r = rows.begin; r < rows.end; ++r) {
    std::uint8_t* row = plane + (2 * level_.rows[r].y + 1) * cell_stride_;
    const std::uint32_t end = level_.rows[r + 1].begin;
    for (std::uint32_t i = level_.rows[r].begin; i < end; ++i) {
      const std::uint32_t byte = (2 * level_.x[i] + kMargin) / 8;
      row[byte] = 0;
      row[byte + cell_stride_] = 0;
    }
  }
}

// --- Searching ---

void SearchNeighbors::begin_slice(std::size_t first_row, std::size_t end_row) {
  const std::uint32_t z = level_.rows[first_row].z;
  const std::size_t last = level_.rows.size() - 1;
  const bool follows =
      slices_[2] == first_row && slices_[2] > slices_[1] && level_.rows[slices_[1]].z + 1 == z;
  slices_[0] = follows ? slices_[1] : first_row;
  slices_[1] = first_row;
  slices_[2] = slices_[3] = end_row;
  while (slices_[3] < last && level_.rows[slices_[3]].z == z + 1) ++slices_[3];
}

SearchNeighbors::Row::Range SearchNeighbors::find(std::size_t begin, std::size_t end,
                                                  std::uint32_t y) const {
  const auto first = level_.rows.begin();
  const auto row = std::lower_bound(
      first + static_cast<std::ptrdiff_t>(begin), first + static_cast<std::ptrdiff_t>(end), y,
      [](const RasterLevel::Row& r, std::uint32_t value) { return r.y < value; });
  if (row == first + static_cast<std::ptrdiff_t>(end) || row->y != y) return {};
  return {row->begin, (row + 1)->begin};
}

SearchNeighbors::Row SearchNeighbors::row(std::size_t number) {
  const std::uint32_t y = level_.rows[number].y;
  Row row;
  row.level_ = &level_;
  for (std::size_t slice = 0; slice < 3; ++slice) {
    for (std::uint32_t dy = 0; dy < 3; ++dy) {
      // y - 1 may wrap around; no row has that number.
      row.rows_[slice * 3 + dy] = find(slices_[slice], slices_[slice + 1], y + dy - 1);
    }
  }
  return row;
}

std::uint64_t SearchNeighbors::Row::word(std::uint32_t x, std::uint32_t left_mask) {
  using namespace neighborhood;
  // The masks of the nodes at x - 1, x and x + 1 in each row.
  std::array<std::array<std::uint32_t, 3>, 9> masks{};
  std::uint32_t nodes = 0;
  for (std::uint32_t r = 0; r < 9; ++r) {
    Range& range = rows_[r];
    while (range.next < range.end && level_->x[range.next] + 1 < x) ++range.next;
    for (std::uint32_t i = range.next; i < range.end && level_->x[i] <= x + 1; ++i) {
      const std::uint32_t column = level_->x[i] + 1 - x;
      masks[r][column] = level_->masks[i];
      nodes |= 1u << (3 * r + column);
    }
  }
  // Four cells of a row: the children `child` and `child` + 1 of three nodes.
  const auto cells_of = [&masks](std::size_t r, int child) {
    return (masks[r][0] >> (child + 1) & 1u) | (masks[r][1] >> child & 3u) << 1 |
           (masks[r][2] >> child & 1u) << 3;
  };
  const std::uint32_t cells = cells_of(0, 6) | cells_of(1, 4) << 4 | cells_of(1, 6) << 8 |
                              cells_of(2, 4) << 12 | cells_of(3, 2) << kNearRow |
                              cells_of(3, 6) << kFarRow | right_half(left_mask) << kLeft;
  return neighborhood::word(cells, nodes);
}

}  // namespace pointreel
