#include "codec/octree/sparse_words.h"

#include <cstring>

#include "pointreel/cpu.h"

namespace pointreel {
namespace {

constexpr std::size_t kMostLanes = 8;
static_assert(SliceLevel::kSpare >= kMostLanes);

/// As many numbers as a vector of the processor holds.
typedef std::int32_t Int4 __attribute__((vector_size(16)));
typedef std::int32_t Int8 __attribute__((vector_size(32)));

/// Exchanges the bits of `mask` with those that are `shift` places higher, in the lanes that
/// `where` selects.
template <class Ints>
[[gnu::always_inline]] inline void exchange(Ints& bits, std::int32_t mask, int shift,
                                            const Ints& where) {
  const Ints differ = (bits >> shift ^ bits) & mask & where;
  bits ^= differ ^ differ << shift;
}

/// The cubes of cells, mirrored along an axis.
template <int axis, class Ints>
[[gnu::always_inline]] inline void mirror(Ints& cubes, const Ints& where) {
  if constexpr (axis == 0) exchange(cubes, 0111111111, 2, where);
  if constexpr (axis == 1) exchange(cubes, 0007007007, 6, where);
  if constexpr (axis == 2) exchange(cubes, 0000000777, 18, where);
}

/// What is known along an axis, in one number. The axis along which the fewest neighbours lie,
/// which is often the normal of the surface, has the least.
template <int axis, class Ints>
[[gnu::always_inline]] inline void turn_axis(const Ints& sums, const Ints& parents, Ints& cubes,
                                             Ints& orientations, Ints& out) {
  const Ints up = sums >> (8 * axis) & 15, down = sums >> (8 * axis + 4) & 15;
  const Ints parents_up = parents >> (8 * axis) & 15, parents_down = parents >> (8 * axis + 4) & 15;
  const Ints octant = parents >> (29 + axis) & 1;
  Ints lean = up - down, parents_lean = parents_up - parents_down;
  // The sign is that of the first of the three that has one.
  const Ints score = 20 * lean + 2 * parents_lean + 2 * octant - 1;
  const Ints negative = score >> 31;
  mirror<axis>(cubes, negative);
  orientations |= negative & 1 << axis;
  lean = (lean ^ negative) - negative;
  parents_lean = (parents_lean ^ negative) - negative;
  const Ints fields = (octant ^ (negative & 1)) | ((parents_lean > 0) & 2) |
                      ((parents_lean < 0) & 4) | (((parents_lean > 2) | (parents_lean < -2)) & 8) |
                      ((lean > 0) & 16) | ((lean > 2) & 32);
  const Ints spread = 4 * (up + down) + parents_up + parents_down;
  out = spread << 14 | (255 - ((score ^ negative) - negative)) << 6 | fields;
}

/// Sets the lanes of `wrong` in which they had to be exchanged.
template <class Ints>
[[gnu::always_inline]] inline void put_in_order(Ints& a, Ints& b, Ints& wrong) {
  wrong = a > b;
  const Ints differ = (a ^ b) & wrong;
  a ^= differ;
  b ^= differ;
}

template <class Ints>
[[gnu::always_inline]] inline void exchange_xy(Ints& cubes, const Ints& where) {
  exchange(cubes, 0042042042, 2, where);
  exchange(cubes, 0004004004, 4, where);
}

template <class Ints>
[[gnu::always_inline]] inline void exchange_yz(Ints& cubes, const Ints& where) {
  exchange(cubes, 0000700070, 6, where);
  exchange(cubes, 0000000700, 12, where);
}

/// What describes the nodes of a slice.
struct Descriptions {
  const std::uint32_t *sums, *parents, *cubes;
  std::uint32_t *low, *high;
  Orientation* orientations;
};

template <class Ints>
[[gnu::always_inline]] inline void describe_nodes(const Descriptions& nodes, std::size_t size) {
  constexpr std::size_t kLanes = sizeof(Ints) / 4;
  for (std::size_t i = 0; i < size; i += kLanes) {
    Ints sums, parents, cubes, orientations = {};
    std::memcpy(&sums, nodes.sums + i, sizeof(sums));
    std::memcpy(&parents, nodes.parents + i, sizeof(parents));
    std::memcpy(&cubes, nodes.cubes + i, sizeof(cubes));
    Ints x, y, z;
    turn_axis<0>(sums, parents, cubes, orientations, x);
    turn_axis<1>(sums, parents, cubes, orientations, y);
    turn_axis<2>(sums, parents, cubes, orientations, z);
    Ints wrong;
    put_in_order(x, y, wrong);
    exchange_xy(cubes, wrong);
    orientations |= wrong & 8;
    put_in_order(y, z, wrong);
    exchange_yz(cubes, wrong);
    orientations |= wrong & 16;
    put_in_order(x, y, wrong);
    exchange_xy(cubes, wrong);
    orientations |= wrong & 32;
    const Ints count = sums >> 24 & 31, parents_count = parents >> 24 & 31;
    // Comparisons give -1.
    const Ints density = -((count > 2) + (count > 5) + (count > 9));
    const Ints parents_density =
        -((parents_count > 4) + (parents_count > 7) + (parents_count > 10));
    const Ints low = (cubes & 0x1fff) | cubes >> 14 << 13 | (x & 63) << 26;
    const Ints high = (y & 63) | (z & 63) << 6 | density << 12 | parents_density << 14;
    std::memcpy(nodes.low + i, &low, sizeof(low));
    std::memcpy(nodes.high + i, &high, sizeof(high));
    typedef std::uint8_t Byte8 __attribute__((vector_size(kLanes)));
    const Byte8 bytes = __builtin_convertvector(orientations, Byte8);
    std::memcpy(nodes.orientations + i, &bytes, sizeof(bytes));
  }
}

#if defined(__x86_64__)
[[gnu::target("avx2")]] void describe_nodes_avx2(const Descriptions& nodes, std::size_t count) {
  describe_nodes<Int8>(nodes, count);
}
#endif

}  // namespace

SparseWalk::SparseWalk(SliceLevel& level)
    : level_(level), search_(level), wide_((cpu_features() & kCpuAvx2) != 0) {
  const std::uint64_t planes = NodePlanes::memory(level.level);
  if (planes <= 65536 + 64 * std::uint64_t{level.size()} ||
      (planes <= kHugePlanes && level.size() >= kManyNodes)) {
    planes_.emplace(level);
  }
}

void SparseWalk::visit(std::size_t slice) {
  const std::uint32_t begin = level_.slices[slice].begin;
  size_ = level_.slices[slice + 1].begin - begin;
  if (cubes_.size() < size_ + kMostLanes) {
    const std::size_t size = size_ + size_ / 2 + kMostLanes;
    for (auto* values : {&cubes_, &low_, &high_}) values->resize(size);
    orientations_.resize(size);
  }
  const auto found = [&](std::uint32_t node, const CellsAround& around) {
    cubes_[node - begin] = around.cube();
    level_.inherited[node] = around.sums();
  };
  if (planes_) {
    planes_->move_to(slice);
    const std::uint32_t end = begin + static_cast<std::uint32_t>(size_);
    for (std::uint32_t i = begin; i < end; ++i) found(i, planes_->around(level_.x[i], level_.y[i]));
  } else {
    search_.visit(slice, found);
  }
  describe(begin);
}

void SparseWalk::describe(std::uint32_t begin) {
  const Descriptions nodes{
      &level_.inherited[begin], &level_.parents[begin], cubes_.data(), low_.data(), high_.data(),
      orientations_.data()};
#if defined(__x86_64__)
  if (wide_) {
    describe_nodes_avx2(nodes, size_);
    return;
  }
#endif
  describe_nodes<Int4>(nodes, size_);
}

}  // namespace pointreel
