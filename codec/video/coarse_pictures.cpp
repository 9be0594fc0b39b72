#include "codec/video/coarse_pictures.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdlib>

#include "common/base/for_each.h"

namespace pointreel {
namespace {

/// The mean of numbers, rounded to the nearest.
int rounded_mean(int sum, int count) { return (sum + count / 2) / count; }

/// The four pixels of one: which of them are on the surface of the first, and the mean depth.
struct Quad {
  std::array<bool, 4> on{};
  int count = 0, depth = 0;

  Quad(const std::array<std::int16_t, 4>& depths, int limit) {
    int first = -1, sum = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      if (depths[i] < 0) continue;
      if (first < 0) first = depths[i];
      if (std::abs(depths[i] - first) > limit) continue;
      on[i] = true;
      ++count;
      sum += depths[i];
    }
    if (count > 0) depth = rounded_mean(sum, count);
  }
};

/// Halves a patch.
class PatchHalves {
 public:
  PatchHalves(const VideoGroup& group, const Patch& from, const PixelDepths& depths,
              const Av1Picture* colors, const Patch& to, CoarsePictures& out)
      : group_(group),
        from_(from),
        depths_(depths),
        colors_(colors),
        to_(to),
        out_(out),
        limit_(same_surface(group.depth[static_cast<std::size_t>(from.view)])) {}

  /// Returns how many points there are.
  std::size_t make() {
    std::size_t points = 0;
    for (int y = 0; y < to_.height; ++y) points += make_row(y);
    if (colors_ != nullptr) {
      std::uint8_t* const chroma = out_.samples.data() + group_.pixels();
      halve_chroma(colors_->cb, chroma);
      halve_chroma(colors_->cr, chroma + group_.pixels() / 4);
    }
    return points;
  }

 private:
  const std::int16_t* depths_of(int y) const {
    return &depths_.values[group_.pixel(from_.atlas_x, from_.atlas_y + y)];
  }

  std::size_t make_row(int y) {
    const std::int16_t* const up = depths_of(2 * y);
    const std::int16_t* const down = depths_of(2 * y + 1);
    std::int16_t* const out = &out_.depths.values[group_.pixel(to_.atlas_x, to_.atlas_y + y)];
    std::fill_n(out, to_.width, PixelDepths::kNoPoint);
    std::uint8_t* luma_out = nullptr;
    const std::uint8_t *luma_up = nullptr, *luma_down = nullptr;
    if (colors_ != nullptr) {
      luma_out = out_.samples.data() + group_.pixel(to_.atlas_x, to_.atlas_y + y);
      luma_up = colors_->luma.from(from_.atlas_x, from_.atlas_y + 2 * y);
      luma_down = colors_->luma.from(from_.atlas_x, from_.atlas_y + 2 * y + 1);
    }
    std::size_t points = 0;
    for (int x = 0; x < from_.width / 2; ++x) {
      const int at = 2 * x;
      if ((up[at] & up[at + 1] & down[at] & down[at + 1]) < 0) continue;  // none has a point
      const Quad quad({up[at], up[at + 1], down[at], down[at + 1]}, limit_);
      out[x] = static_cast<std::int16_t>(quad.depth);
      ++points;
      if (colors_ == nullptr) continue;
      const int sum = quad.on[0] * luma_up[at] + quad.on[1] * luma_up[at + 1] +
                      quad.on[2] * luma_down[at] + quad.on[3] * luma_down[at + 1];
      luma_out[x] = static_cast<std::uint8_t>(rounded_mean(sum, quad.count));
    }
    return points;
  }

  void halve_chroma(const PlaneView<std::uint8_t>& plane, std::uint8_t* out) const {
    const int x0 = from_.atlas_x / 2, y0 = from_.atlas_y / 2;
    for (int y = 0; y < to_.height / 2; ++y) {
      const std::uint8_t* const up = plane.from(x0, y0 + 2 * y);
      const std::uint8_t* const down = plane.from(x0, y0 + 2 * y + 1);
      std::uint8_t* const row = out + (y0 + y) * (group_.width / 2) + x0;
      for (int x = 0; x < from_.width / 4; ++x)
        row[x] = static_cast<std::uint8_t>(
            rounded_mean(up[2 * x] + up[2 * x + 1] + down[2 * x] + down[2 * x + 1], 4));
    }
  }

  const VideoGroup& group_;
  const Patch& from_;
  const PixelDepths& depths_;
  const Av1Picture* const colors_;
  const Patch& to_;
  CoarsePictures& out_;
  const int limit_;
};

VideoGroup with_wider_pixels(const VideoGroup& group) {
  VideoGroup wider = group;
  wider.pitch *= 2.0;
  for (DepthSteps& steps : wider.depth) steps = {0.5f * steps.begin, 2.0f * steps.steps};
  for (Patch& patch : wider.patches) {
    patch.x /= 2;
    patch.y /= 2;
    // Rows of patches are read by so many pixels at once.
    patch.width = (patch.width / 2 + kPatchGrain - 1) / kPatchGrain * kPatchGrain;
    patch.height /= 2;
  }
  return wider;
}

}  // namespace

CoarsePictures halve(const VideoGroup& group, const PixelDepths& depths, const Av1Picture* colors,
                     const Executor& executor) {
  CoarsePictures out{with_wider_pixels(group), {}, {}, {}};
  const std::size_t pixels = group.pixels();
  out.depths.values.resize(pixels);
  out.depths.points.resize(group.patches.size());
  if (colors != nullptr) {
    out.samples.resize(pixels + pixels / 2);
    const std::uint8_t* const luma = out.samples.data();
    const std::uint8_t* const cb = luma + pixels;
    out.colors = Av1Picture{nullptr,
                            {},
                            {luma, group.width},
                            {cb, group.width / 2},
                            {cb + pixels / 4, group.width / 2}};
  }
  for_each(executor, static_cast<int>(group.patches.size()), [&](int i) {
    const auto p = static_cast<std::size_t>(i);
    out.depths.points[p] =
        PatchHalves(group, group.patches[p], depths, colors, out.group.patches[p], out).make();
  });
  return out;
}

}  // namespace pointreel
