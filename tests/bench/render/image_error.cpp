#include "tests/bench/render/image_error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>

#include <tbb/parallel_for.h>

namespace pointreel::bench {
namespace {

constexpr int kReach = 5;  // pixels of the window on each side of its middle
constexpr double kSigma = 1.5;
constexpr float kC1 = 0.01f * 255.0f * 0.01f * 255.0f, kC2 = 0.03f * 255.0f * 0.03f * 255.0f;

using Window = std::array<float, 2 * kReach + 1>;

Window gaussian() {
  Window window;
  for (int i = -kReach; i <= kReach; ++i) {
    window[static_cast<std::size_t>(i + kReach)] =
        static_cast<float>(std::exp(-0.5 * i * i / (kSigma * kSigma)));
  }
  return window;
}

float luma(const glm::u8vec3& c) {
  return 0.2126f * static_cast<float>(c.x) + 0.7152f * static_cast<float>(c.y) +
         0.0722f * static_cast<float>(c.z);
}

/// Weighted sums over the window of both pictures, their squares and their product.
struct Moments {
  float a = 0.0f, b = 0.0f, aa = 0.0f, bb = 0.0f, ab = 0.0f;

  void add(float weight, const Moments& m) {
    a += weight * m.a;
    b += weight * m.b;
    aa += weight * m.aa;
    bb += weight * m.bb;
    ab += weight * m.ab;
  }
};

float similarity(const Moments& sum, float weight) {
  const float a = sum.a / weight, b = sum.b / weight;
  const float va = sum.aa / weight - a * a, vb = sum.bb / weight - b * b;
  const float cov = sum.ab / weight - a * b;
  return (2.0f * a * b + kC1) * (2.0f * cov + kC2) / ((a * a + b * b + kC1) * (va + vb + kC2));
}

bool inside(std::span<const std::uint8_t> mask, std::size_t i) { return mask.empty() || mask[i]; }

}  // namespace

std::optional<double> psnr(const Image& a, const Image& b, std::span<const std::uint8_t> mask) {
  std::uint64_t squares = 0, channels = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    if (!inside(mask, i)) continue;
    const glm::ivec3 d = glm::ivec3(a.pixels[i]) - glm::ivec3(b.pixels[i]);
    squares += static_cast<std::uint64_t>(d.x * d.x + d.y * d.y + d.z * d.z);
    channels += 3;
  }
  if (squares == 0) return std::nullopt;
  const double mean = static_cast<double>(squares) / static_cast<double>(channels);
  return 10.0 * std::log10(255.0 * 255.0 / mean);
}

Similarity::Similarity(const Image& a, const Image& b) : values_(a.pixels.size(), 1.0f) {
  const int width = a.width, height = a.height;
  const Window window = gaussian();
  // Only rows and columns with differences count. A window of equal pixels gives exactly 1.
  int left = width, right = -1, top = height, bottom = -1;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (a.at(x, y) == b.at(x, y)) continue;
      left = std::min(left, x);
      right = std::max(right, x);
      top = std::min(top, y);
      bottom = y;
    }
  }
  if (right < 0) return;
  left = std::max(left - kReach, 0);
  right = std::min(right + kReach, width - 1);
  top = std::max(top - kReach, 0);
  bottom = std::min(bottom + kReach, height - 1);

  tbb::parallel_for(top, bottom + 1, [&](int y) {
    // The window is separable: first down the columns, then along the row.
    const int first_row = std::max(y - kReach, 0), last_row = std::min(y + kReach, height - 1);
    const int first = std::max(left - kReach, 0), last = std::min(right + kReach, width - 1);
    std::vector<Moments> columns(static_cast<std::size_t>(last - first + 1));
    float down = 0.0f;
    for (int row = first_row; row <= last_row; ++row) {
      const float weight = window[static_cast<std::size_t>(row - y + kReach)];
      down += weight;
      for (int x = first; x <= last; ++x) {
        const float p = luma(a.at(x, row)), q = luma(b.at(x, row));
        columns[static_cast<std::size_t>(x - first)].add(weight, {p, q, p * p, q * q, p * q});
      }
    }
    for (int x = left; x <= right; ++x) {
      Moments sum;
      float across = 0.0f;
      for (int i = std::max(x - kReach, 0); i <= std::min(x + kReach, width - 1); ++i) {
        const float weight = window[static_cast<std::size_t>(i - x + kReach)];
        across += weight;
        sum.add(weight, columns[static_cast<std::size_t>(i - first)]);
      }
      values_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
              static_cast<std::size_t>(x)] = similarity(sum, down * across);
    }
  });
}

double Similarity::mean(std::span<const std::uint8_t> mask) const {
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < values_.size(); ++i) {
    if (!inside(mask, i)) continue;
    sum += static_cast<double>(values_[i]);
    ++count;
  }
  return count > 0 ? sum / static_cast<double>(count) : 1.0;
}

Coverage compare_coverage(std::span<const std::uint8_t> truth,
                          std::span<const std::uint8_t> covered) {
  std::size_t there = 0, missing = 0, beyond = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    there += truth[i] != 0;
    missing += truth[i] != 0 && covered[i] == 0;
    beyond += truth[i] == 0 && covered[i] != 0;
  }
  Coverage coverage;
  const auto of = [](std::size_t part, std::size_t whole) {
    return static_cast<double>(part) / static_cast<double>(whole);
  };
  if (there + beyond > 0) coverage.iou = of(there - missing, there + beyond);
  if (there == 0) return coverage;
  coverage.truth = of(there, truth.size());
  coverage.holes = of(missing, there);
  coverage.dilation = of(beyond, there);
  return coverage;
}

Difference difference(const Image& a, const Image& b) {
  Difference difference;
  std::uint64_t squares = 0, seen = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    const glm::ivec3 d = glm::abs(glm::ivec3(a.pixels[i]) - glm::ivec3(b.pixels[i]));
    const int largest = std::max({d.x, d.y, d.z});
    difference.largest = std::max(difference.largest, largest);
    seen += largest > 1;
    squares += static_cast<std::uint64_t>(d.x * d.x + d.y * d.y + d.z * d.z);
  }
  if (!a.pixels.empty()) {
    difference.rms =
        std::sqrt(static_cast<double>(squares) / static_cast<double>(3 * a.pixels.size()));
    difference.share = static_cast<double>(seen) / static_cast<double>(a.pixels.size());
  }
  return difference;
}

}  // namespace pointreel::bench
