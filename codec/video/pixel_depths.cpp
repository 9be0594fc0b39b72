#include "codec/video/pixel_depths.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdlib>
#include <cstring>

#include "common/base/for_each.h"

namespace pointreel {
namespace {

constexpr float kSameSurface = 2.0f;  ///< pixels
constexpr int kLeastSupport = 3;
constexpr std::int16_t kNone = PixelDepths::kNoPoint;

/// The pixels of a row of a block, 16 bits each.
using Four = std::uint64_t;
static_assert(sizeof(Four) == kBlock * sizeof(std::int16_t));
constexpr Four four(std::array<std::int16_t, kBlock> pixels) { return std::bit_cast<Four>(pixels); }
constexpr Four kNoPoints = four({kNone, kNone, kNone, kNone});

/// For each way in which the pixels of a row of a block can be on, ones where they are.
constexpr std::array<Four, 1 << kBlock> make_masks() {
  std::array<Four, 1 << kBlock> masks{};
  for (unsigned on = 0; on < masks.size(); ++on) {
    std::array<std::int16_t, kBlock> pixels{};
    for (unsigned x = 0; x < kBlock; ++x)
      pixels[x] = static_cast<std::int16_t>((on >> x & 1u) != 0 ? -1 : 0);
    masks[on] = four(pixels);
  }
  return masks;
}
constexpr auto kMasks = make_masks();

/// Reads a patch row by row.
class PatchReader {
 public:
  PatchReader(const VideoGroup& group, const Patch& patch, const BlockMask& blocks,
              const PlaneView<std::uint16_t>& picture)
      : patch_(patch),
        blocks_(blocks),
        picture_(picture),
        limit_(static_cast<std::int16_t>(
            same_surface(group.depth[static_cast<std::size_t>(patch.view)]))) {
    for (std::vector<std::int16_t>& row : rows_)
      row.assign(static_cast<std::size_t>(patch.width) + 2, kNone);
    edges_.resize(static_cast<std::size_t>(patch.width / kBlock));
    any_.fill(false);
  }

  /// The depths of a row, and how many points it has; rows are wanted in their order.
  std::size_t read(int y, std::int16_t* out) {
    if (y == 0) load(0);
    load(y + 1);
    if (!any_[ring(y)]) {
      std::fill(out, out + patch_.width, kNone);
      return 0;
    }
    return keep_supported(row(y - 1), row(y), row(y + 1), out, patch_.width);
  }

 private:
  static std::size_t ring(int y) { return static_cast<std::size_t>(y + 3) % 3; }
  /// With a pixel before and one behind it.
  std::int16_t* row(int y) { return rows_[ring(y)].data() + 1; }

  /// What the picture has in a row; kNone where it has no point.
  void load(int y) {
    std::int16_t* const out = row(y);
    bool& any = any_[ring(y)];
    if (y < patch_.height && y % kBlock == 0) {
      edges_of_row(patch_, blocks_, y / kBlock, edges_.data());
      any_edges_ = std::any_of(edges_.begin(), edges_.end(), [](auto e) { return e != 0; });
    }
    if (y >= patch_.height || !any_edges_) {
      if (any) std::fill(out, out + patch_.width, kNone);
      any = false;
      return;
    }
    any = true;
    const std::uint16_t* const from =
        picture_.samples + (patch_.atlas_y + y) * picture_.stride + patch_.atlas_x;
    const int shift = y % kBlock * kBlock;
    for (std::size_t b = 0; b < edges_.size(); ++b) {
      const Four mask = kMasks[edges_[b] >> shift & 15u];
      Four pixels;
      std::memcpy(&pixels, from + kBlock * b, sizeof(Four));
      pixels = (pixels & mask) | (kNoPoints & ~mask);
      std::memcpy(out + kBlock * b, &pixels, sizeof(Four));
    }
  }

  std::size_t keep_supported(const std::int16_t* up, const std::int16_t* middle,
                             const std::int16_t* down, std::int16_t* out, int count) const {
    const std::int16_t limit = limit_;
    std::uint16_t points = 0;
    for (int x = 0; x < count; ++x) {
      const std::int16_t depth = middle[x];
      const auto supports = [&](const std::int16_t* line, int dx) {
        const auto step = static_cast<std::int16_t>(line[x + dx] - depth);
        const auto size = static_cast<std::int16_t>(step < 0 ? -step : step);
        return static_cast<std::int16_t>(size <= limit ? 1 : 0);
      };
      const auto support = static_cast<std::int16_t>(
          supports(up, -1) + supports(up, 0) + supports(up, 1) + supports(middle, -1) +
          supports(middle, 1) + supports(down, -1) + supports(down, 0) + supports(down, 1));
      out[x] = support >= kLeastSupport ? depth : kNone;
      points = static_cast<std::uint16_t>(points + (out[x] >= 0 ? 1 : 0));
    }
    return points;
  }

  const Patch& patch_;
  const BlockMask& blocks_;
  const PlaneView<std::uint16_t>& picture_;
  const std::int16_t limit_;
  std::array<std::vector<std::int16_t>, 3> rows_;
  std::array<bool, 3> any_;
  std::vector<std::uint16_t> edges_;
  bool any_edges_ = false;
};

}  // namespace

int same_surface(const DepthSteps& steps) {
  return static_cast<int>(
      std::min(kSameSurface * steps.steps + 1e-3f, static_cast<float>(kDepthValues)));
}

PixelDepths read_depths(const VideoGroup& group, const BlockMask& blocks,
                        const PlaneView<std::uint16_t>& picture, const Executor& executor) {
  PixelDepths read;
  read.values.resize(group.pixels());
  read.points.resize(group.patches.size());
  for_each(executor, static_cast<int>(group.patches.size()), [&](int i) {
    const Patch& patch = group.patches[static_cast<std::size_t>(i)];
    PatchReader reader(group, patch, blocks, picture);
    std::size_t& points = read.points[static_cast<std::size_t>(i)];
    for (int y = 0; y < patch.height; ++y)
      points += reader.read(y, &read.values[group.pixel(patch.atlas_x, patch.atlas_y + y)]);
  });
  return read;
}

}  // namespace pointreel
