#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "client/render/image.h"

/// How far a picture is from another: 8-bit sRGB values as they are stored, so in the units that a
/// viewer sees.
namespace pointreel::bench {

/// One value for each pixel of a picture, rows from the top; not zero is inside.
using Mask = std::vector<std::uint8_t>;

/// 10 log10(255^2 / mean squared error of all three channels) over the pixels of `mask`, or over
/// all if it is empty. Nothing where the error is exactly zero, or where there is no pixel. The
/// pictures are of one size.
std::optional<double> psnr(const Image& a, const Image& b, std::span<const std::uint8_t> mask = {});

/// Structural similarity (Z. Wang et al., "Image Quality Assessment", 2004) of BT.709 luma: a
/// Gaussian window of 11x11 pixels and sigma 1.5, K1 = 0.01, K2 = 0.03, L = 255. At the edges of
/// the picture the window is cut off and its weights add up to one again.
class Similarity {
 public:
  Similarity(const Image& a, const Image& b);

  /// Mean over the pixels of `mask`, or over all if it is empty; 1 where there is no pixel.
  double mean(std::span<const std::uint8_t> mask = {}) const;

 private:
  std::vector<float> values_;  ///< of each pixel
};

/// What is drawn against what is there: METRICS.md, as shares of the truth's pixels.
struct Coverage {
  double truth = 0.0;     ///< share of the picture that the truth covers
  double holes = 0.0;     ///< |M \ R| / |M|
  double dilation = 0.0;  ///< |R \ M| / |M|
  double iou = 1.0;       ///< |M and R| / |M or R|
};
/// Of equally large masks. Where the truth covers nothing, holes and dilation are 0.
Coverage compare_coverage(std::span<const std::uint8_t> truth,
                          std::span<const std::uint8_t> covered);

struct Difference {
  double rms = 0.0;    ///< of all channels of all pixels, in steps of 1 / 255
  int largest = 0;     ///< of one channel
  double share = 0.0;  ///< of the pixels with a channel that differs by more than 1
};
Difference difference(const Image& a, const Image& b);

}  // namespace pointreel::bench
