#pragma once

#include <cstdint>
#include <vector>

#include "codec/octree/alphabet.h"
#include "codec/video/video_group.h"
#include "pointreel/bytes.h"
#include "pointreel/error.h"

/// Which pixels of the pictures of a layered depth video hold a point: FORMAT.md, "Occupancy".
namespace pointreel {

/// Occupancy is coded for blocks of so many pixels by so many.
inline constexpr int kBlock = 4;

/// A flag for each block of the pictures, row by row; 0 outside of patches.
struct BlockMask {
  int width = 0, height = 0;  ///< in blocks
  std::vector<std::uint8_t> on;

  explicit BlockMask(const VideoGroup& group);
  std::uint8_t& at(int x, int y) {
    return on[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
              static_cast<std::size_t>(x)];
  }
  std::uint8_t at(int x, int y) const {
    return on[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
              static_cast<std::size_t>(x)];
  }
};

/// The pixels that hold a point in each block of one row of a patch, row `y` of its blocks: bit
/// kBlock * row + column. The edges of a block are rounded off by its neighbours: a pixel is on
/// where the flags of the blocks, interpolated between their centres, are at least a half.
void edges_of_row(const Patch& patch, const BlockMask& blocks, int y, std::uint16_t* pixels);

/// A flag for each pixel of the pictures: whether it holds a point.
std::vector<std::uint8_t> pixel_mask(const VideoGroup& group, const BlockMask& blocks);

/// Codes the masks of a group's frames, in their order. What was learned from one frame serves the
/// next, and the mask of the frame before predicts the next one.
class OccupancyCoder {
 public:
  explicit OccupancyCoder(const VideoGroup& group);

  void encode(const BlockMask& blocks, Bytes& out);
  /// Trust: the bytes may be hostile. Any bytes give a mask or the error `invalid`, in time and
  /// memory that depend on the size of the pictures only.
  Result<BlockMask> decode(ByteView bytes);

 private:
  template <class Coder>
  void code(Coder& coder, BlockMask& blocks);

  const VideoGroup* group_;
  BlockMask before_;
  std::vector<Alphabet16> alphabets_;
};

}  // namespace pointreel
