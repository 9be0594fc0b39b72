#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "client/render/image.h"

/// How far a picture differs from another. All measures use the stored 8-bit sRGB values, the units
/// that a viewer sees. BENCHMARKS.md, "How speed and error are measured".
namespace pointreel::bench {

/// One value for each pixel of a picture, rows from top to bottom. Pixels that are not 0 are
/// inside.
using Mask = std::vector<std::uint8_t>;

/// 10 log10(255^2 / mean squared error of all three channels) over the pixels of `mask`, or over
/// all pixels if it is empty. Returns nothing if the error is exactly zero or there are no pixels.
/// Both pictures have the same size.
std::optional<double> psnr(const Image& a, const Image& b, std::span<const std::uint8_t> mask = {});

/// Structural similarity (Z. Wang et al., "Image Quality Assessment", 2004) of BT.709 luma, with a
/// Gaussian window of 11x11 pixels and sigma 1.5, K1 = 0.01, K2 = 0.03 and L = 255. At the edges of
/// the picture the window is cut off and its weights are normalised again.
class Similarity {
 public:
  Similarity(const Image& a, const Image& b);

  /// The mean over the pixels of `mask`, or over all pixels if it is empty. 1 if there are none.
  double mean(std::span<const std::uint8_t> mask = {}) const;

 private:
  std::vector<float> values_;  ///< one per pixel
};

/// The pixels that are covered in the truth (M) and in the picture (R). BENCHMARKS.md, "How speed
/// and error are measured".
struct Coverage {
  double truth = 0.0;     ///< share of the picture that the truth covers
  double holes = 0.0;     ///< |M \ R| / |M|
  double dilation = 0.0;  ///< |R \ M| / |M|
  double iou = 1.0;       ///< |M and R| / |M or R|
};
/// Compares masks of the same size. If the truth covers nothing, holes and dilation are 0.
Coverage compare_coverage(std::span<const std::uint8_t> truth,
                          std::span<const std::uint8_t> covered);

struct Difference {
  double rms = 0.0;    ///< over all channels of all pixels, in steps of 1/255
  int largest = 0;     ///< largest difference of a channel
  double share = 0.0;  ///< share of the pixels with a channel that differs by more than 1
};
Difference difference(const Image& a, const Image& b);

}  // namespace pointreel::bench
