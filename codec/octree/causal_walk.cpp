#include "codec/octree/causal_walk.h"

namespace pointreel {

CausalWalk::CausalWalk(SliceLevel& level) : level_(level), nodes_(level) {
  const std::size_t side = std::size_t{1} << level.level;
  stride_ = side / 2 + 4;
  const std::size_t size = stride_ * (2 * side + 2);
  bytes_.resize(2 * size);
  below_ = bytes_.data();
  beside_ = below_ + size;
}

void CausalWalk::clear(std::uint8_t* plane, std::size_t slice) {
  const std::uint32_t end = level_.slices[slice + 1].begin;
  for (std::uint32_t i = level_.slices[slice].begin; i < end; ++i) {
    std::uint8_t* byte = plane + (2 * level_.y[i] + 1) * stride_ + (level_.x[i] + kMargin) / 2;
    byte[0] = byte[stride_] = 0;
  }
}

void CausalWalk::finish(std::size_t slice) {
  if (slice_below_ != kNoSlice) clear(below_, slice_below_);
  slice_below_ = kNoSlice;
  if (slice_above(level_, slice) == kNoSlice) {
    clear(beside_, slice);
  } else {
    std::swap(below_, beside_);
    slice_below_ = slice;
  }
}

}  // namespace pointreel
