#include "codec/video_encode/place_patches.h"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace pointreel {
namespace {

constexpr int kPictureWidth = 2048;
/// The least that the encoder takes.
constexpr int kLeastSide = 64;

int down_to_grain(int pixels) { return pixels / kPatchGrain * kPatchGrain; }
int up_to_grain(int pixels) { return down_to_grain(pixels + kPatchGrain - 1); }

/// The rectangle of the layer's pixels in all frames; its width is 0 if there are none.
Patch bounding_patch(std::span<const ViewLayers> frames, int view, int layer) {
  int left = kLargestAtlas, top = kLargestAtlas, right = 0, bottom = 0;
  for (const ViewLayers& frame : frames) {
    const ViewLayer& pixels =
        frame[static_cast<std::size_t>(view)][static_cast<std::size_t>(layer)];
    pixels.for_each([&](int x, int y, float) {
      left = std::min(left, x);
      right = std::max(right, x + 1);
      top = std::min(top, y);
      bottom = std::max(bottom, y + 1);
    });
  }
  Patch patch{.view = view, .layer = layer};
  if (right == 0) return patch;
  patch.x = down_to_grain(left);
  patch.y = down_to_grain(top);
  patch.width = up_to_grain(right) - patch.x;
  patch.height = up_to_grain(bottom) - patch.y;
  return patch;
}

/// Puts patches onto a skyline, tall ones first.
void place(std::vector<Patch>& patches, int width) {
  std::stable_sort(patches.begin(), patches.end(),
                   [](const Patch& a, const Patch& b) { return a.height > b.height; });
  std::vector<int> skyline(static_cast<std::size_t>(width / kPatchGrain), 0);
  for (Patch& patch : patches) {
    const auto columns = static_cast<std::size_t>(patch.width / kPatchGrain);
    int best = kLargestAtlas * 64;
    std::size_t at = 0;
    for (std::size_t x = 0; x + columns <= skyline.size(); ++x) {
      const auto first = skyline.begin() + static_cast<std::ptrdiff_t>(x);
      const int top = *std::max_element(first, first + static_cast<std::ptrdiff_t>(columns));
      if (top < best) {
        best = top;
        at = x;
      }
    }
    patch.atlas_x = static_cast<int>(at) * kPatchGrain;
    patch.atlas_y = best;
    for (std::size_t x = at; x < at + columns; ++x) skyline[x] = best + patch.height;
  }
}

}  // namespace

void place_patches(std::span<const ViewLayers> frames, VideoGroup& group) {
  group.patches.clear();
  int widest = 0;
  for (int view = 0; view < kViews; ++view) {
    for (int layer = 0; layer < kViewLayers; ++layer) {
      const Patch patch = bounding_patch(frames, view, layer);
      if (patch.width == 0) continue;
      group.patches.push_back(patch);
      widest = std::max(widest, patch.width);
    }
  }
  place(group.patches, std::max(widest, kPictureWidth));
  group.width = group.height = kLeastSide;
  for (const Patch& patch : group.patches) {
    group.width = std::max(group.width, patch.atlas_x + patch.width);
    group.height = std::max(group.height, patch.atlas_y + patch.height);
  }
}

}  // namespace pointreel
