#include "codec/video/occupancy.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "codec/octree/symbol_coder.h"

namespace pointreel {
namespace {

/// Four blocks are one symbol, whose context is 6 blocks before them and the same 4 one frame ago.
constexpr std::size_t kContexts = 1u << 10;

/// For each way in which a block and its 8 neighbours can be on, which of its pixels are.
using EdgeTable = std::array<std::uint16_t, 512>;

constexpr EdgeTable make_edges() {
  EdgeTable table{};
  for (unsigned on = 0; on < table.size(); ++on) {
    for (int y = 0; y < kBlock; ++y) {
      for (int x = 0; x < kBlock; ++x) {
        // Weights of the block, its neighbour to the side, the one above or below, and the corner,
        // in eighths each: pixel centres lie 1 or 3 eighths of a block off its centre.
        const int away_x = x == 0 || x == 3 ? 3 : 1, away_y = y == 0 || y == 3 ? 3 : 1;
        const int side = x < 2 ? 0 : 2, row = y < 2 ? 0 : 2;
        const auto flag = [&](int column, int line) {
          return static_cast<int>(on >> (3 * line + column) & 1u);
        };
        const int sum = (8 - away_x) * (8 - away_y) * flag(1, 1) +
                        away_x * (8 - away_y) * flag(side, 1) +
                        (8 - away_x) * away_y * flag(1, row) + away_x * away_y * flag(side, row);
        if (sum >= 32) table[on] |= static_cast<std::uint16_t>(1u << (kBlock * y + x));
      }
    }
  }
  return table;
}
constexpr EdgeTable kEdges = make_edges();

/// The blocks of a patch; those outside of it are off.
class PatchBlocks {
 public:
  PatchBlocks(const Patch& patch, BlockMask& mask)
      : mask_(mask),
        left_(patch.atlas_x / kBlock),
        top_(patch.atlas_y / kBlock),
        width(patch.width / kBlock),
        height(patch.height / kBlock) {}

  unsigned get(int x, int y) const {
    if (x < 0 || y < 0 || x >= width || y >= height) return 0;
    return mask_.at(left_ + x, top_ + y);
  }
  void set(int x, int y, unsigned on) {
    mask_.at(left_ + x, top_ + y) = static_cast<std::uint8_t>(on);
  }
  unsigned four(int x, int y) const {
    return get(x, y) | get(x + 1, y) << 1 | get(x, y + 1) << 2 | get(x + 1, y + 1) << 3;
  }

 private:
  BlockMask& mask_;
  int left_, top_;

 public:
  const int width, height;
};

}  // namespace

BlockMask::BlockMask(const VideoGroup& group)
    : width(group.width / kBlock),
      height(group.height / kBlock),
      on(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {}

void edges_of_row(const Patch& patch, const BlockMask& blocks, int y, std::uint16_t* pixels) {
  const int left = patch.atlas_x / kBlock, top = patch.atlas_y / kBlock;
  const int width = patch.width / kBlock, height = patch.height / kBlock;
  std::array<const std::uint8_t*, 3> rows{};
  for (int k = 0; k < 3; ++k)
    rows[static_cast<std::size_t>(k)] =
        &blocks.on[static_cast<std::size_t>(top + std::clamp(y + k - 1, 0, height - 1)) *
                       static_cast<std::size_t>(blocks.width) +
                   static_cast<std::size_t>(left)];
  const auto column = [&](int x) {
    return static_cast<unsigned>(rows[0][x] | rows[1][x] << 3 | rows[2][x] << 6);
  };
  unsigned before = column(0), now = before;
  for (int x = 0; x < width; ++x) {
    const unsigned next = column(std::min(x + 1, width - 1));
    pixels[x] = kEdges[before | now << 1 | next << 2];
    before = now;
    now = next;
  }
}

std::vector<std::uint8_t> pixel_mask(const VideoGroup& group, const BlockMask& blocks) {
  std::vector<std::uint8_t> mask(group.pixels());
  std::vector<std::uint16_t> edges;
  for (const Patch& patch : group.patches) {
    edges.resize(static_cast<std::size_t>(patch.width / kBlock));
    for (int y = 0; y < patch.height; ++y) {
      if (y % kBlock == 0) edges_of_row(patch, blocks, y / kBlock, edges.data());
      std::uint8_t* const row = &mask[group.pixel(patch.atlas_x, patch.atlas_y + y)];
      for (int x = 0; x < patch.width; ++x)
        row[x] =
            edges[static_cast<std::size_t>(x / kBlock)] >> (kBlock * (y % kBlock) + x % kBlock) &
            1u;
    }
  }
  return mask;
}

OccupancyCoder::OccupancyCoder(const VideoGroup& group)
    : group_(&group), before_(group), alphabets_(kContexts) {}

template <class Coder>
void OccupancyCoder::code(Coder& coder, BlockMask& blocks) {
  for (const Patch& patch : group_->patches) {
    PatchBlocks now(patch, blocks);
    const PatchBlocks before(patch, before_);
    for (int y = 0; y < now.height; y += 2) {
      for (int x = 0; x < now.width; x += 2) {
        const unsigned context = before.four(x, y) | now.get(x - 1, y) << 4 |
                                 now.get(x - 1, y + 1) << 5 | now.get(x, y - 1) << 6 |
                                 now.get(x + 1, y - 1) << 7 | now.get(x - 1, y - 1) << 8 |
                                 now.get(x + 2, y - 1) << 9;
        const auto four = static_cast<unsigned>(
            coder.code(x >> 1 & 1, alphabets_[context], static_cast<int>(now.four(x, y))));
        now.set(x, y, four & 1u);
        now.set(x + 1, y, four >> 1 & 1u);
        now.set(x, y + 1, four >> 2 & 1u);
        now.set(x + 1, y + 1, four >> 3 & 1u);
      }
    }
  }
  before_ = blocks;
}

void OccupancyCoder::encode(const BlockMask& blocks, Bytes& out) {
  SymbolEncoder coder;
  BlockMask copy = blocks;
  code(coder, copy);
  coder.finish(out);
}

Result<BlockMask> OccupancyCoder::decode(ByteView bytes) {
  SymbolDecoder coder(bytes);
  BlockMask blocks(*group_);
  code(coder, blocks);
  if (!coder.complete()) return fail("the video's occupancy is damaged");
  return blocks;
}

}  // namespace pointreel
