#include "codec/octree/node_planes.h"

#include <algorithm>
#include <utility>

namespace pointreel {

std::size_t slice_below(const SliceLevel& level, std::size_t slice) {
  const bool next = slice > 0 && level.slices[slice - 1].z + 1 == level.slices[slice].z;
  return next ? slice - 1 : kNoSlice;
}

std::size_t slice_above(const SliceLevel& level, std::size_t slice) {
  const bool next =
      slice + 1 < level.slice_count() && level.slices[slice].z + 1 == level.slices[slice + 1].z;
  return next ? slice + 1 : kNoSlice;
}

// --- Bit planes ---

NodePlanes::NodePlanes(const SliceLevel& level) : level_(level) {
  const std::size_t side = std::size_t{1} << level.level;
  stride_ = side / 8 + 3;
  const std::size_t size = stride_ * (side + 2);
  bytes_.resize(3 * size);
  for (std::size_t i = 0; i < 3; ++i) planes_[i] = {bytes_.data() + i * size, kNoSlice};
}

template <class Change>
void NodePlanes::for_each_byte(const Plane& plane, Change&& change) {
  const std::uint32_t end = level_.slices[plane.slice + 1].begin;
  for (std::uint32_t i = level_.slices[plane.slice].begin; i < end; ++i) {
    const std::uint32_t at = level_.x[i] + kMargin;
    change(plane.bits[(level_.y[i] + 1) * stride_ + at / 8], 1u << at % 8);
  }
}

void NodePlanes::hold(Plane& plane, std::size_t slice) {
  if (plane.slice == slice) return;
  if (plane.slice != kNoSlice) for_each_byte(plane, [](std::uint8_t& byte, auto) { byte = 0; });
  plane.slice = slice;
  if (slice == kNoSlice) return;
  for_each_byte(plane, [](std::uint8_t& byte, std::uint32_t bit) {
    byte = static_cast<std::uint8_t>(byte | bit);
  });
}

void NodePlanes::move_to(std::size_t slice) {
  if (planes_[1].slice != slice) {
    std::swap(planes_[0], planes_[1]);
    std::swap(planes_[1], planes_[2]);
  }
  hold(planes_[0], slice_below(level_, slice));
  hold(planes_[1], slice);
  hold(planes_[2], slice_above(level_, slice));
}

// --- Searching ---

void NodeSearch::hold(Sorted& sorted, std::size_t slice) {
  if (sorted.slice == slice) return;
  sorted.slice = slice;
  sorted.places.clear();
  if (slice == kNoSlice) return;
  const std::uint32_t begin = level_.slices[slice].begin, end = level_.slices[slice + 1].begin;
  for (std::uint32_t i = begin; i < end; ++i) {
    sorted.places.push_back({std::uint64_t{level_.y[i]} << 32 | level_.x[i], i - begin});
  }
  std::sort(sorted.places.begin(), sorted.places.end(),
            [](const Place& a, const Place& b) { return a.key < b.key; });
}

void NodeSearch::move_to(std::size_t slice) {
  if (sorted_[1].slice != slice) {
    std::swap(sorted_[0], sorted_[1]);
    std::swap(sorted_[1], sorted_[2]);
  }
  hold(sorted_[0], slice_below(level_, slice));
  hold(sorted_[1], slice);
  hold(sorted_[2], slice_above(level_, slice));
  const std::vector<Place>& own = sorted_[1].places;
  around_.assign(own.size(), {});
  for (std::size_t z = 0; z < 3; ++z) {
    const std::vector<Place>& places = sorted_[z].places;
    for (std::uint64_t y = 0; y < 3; ++y) {
      // The keys that are sought increase, so that one pass finds all of them. They are one row
      // and one column larger than those that are kept, so as not to fall below zero.
      std::size_t next = 0;
      for (const Place& place : own) {
        const std::uint64_t first = place.key + (y << 32);
        const auto key = [&](std::size_t i) {
          return places[i].key + (std::uint64_t{1} << 32) + 1;
        };
        while (next < places.size() && key(next) < first) ++next;
        std::uint32_t bits = 0;
        for (std::size_t i = next; i < places.size() && key(i) <= first + 2; ++i) {
          bits |= 1u << (3 * y + key(i) - first);
        }
        CellsAround& around = around_[place.node];
        (z == 0 ? around.below : z == 1 ? around.beside : around.above) |= bits;
      }
    }
  }
  for (CellsAround& around : around_) around.beside &= ~neighborhood::kOwnCell;
}

}  // namespace pointreel
