#include "client/render/supersampling.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "client/render/srgb.h"

namespace pointreel {
namespace {

std::array<float, 256> linear_of_bytes() {
  std::array<float, 256> linear;
  for (std::size_t i = 0; i < linear.size(); ++i) {
    linear[i] = linear_from_srgb(static_cast<float>(i) / 255.0f);
  }
  return linear;
}

std::uint8_t byte_of_linear(float c) {
  const float srgb = srgb_from_linear(c);
  return static_cast<std::uint8_t>(std::lround(255.0f * std::clamp(srgb, 0.0f, 1.0f)));
}

}  // namespace

Image average_squares(const Image& image, int times) {
  static const std::array<float, 256> kLinear = linear_of_bytes();
  Image small{image.width / times, image.height / times, {}};
  small.pixels.reserve(image.pixels.size() / static_cast<std::size_t>(times * times));
  const float share = 1.0f / static_cast<float>(times * times);
  for (int y = 0; y < small.height; ++y) {
    for (int x = 0; x < small.width; ++x) {
      glm::vec3 sum(0.0f);
      for (int i = 0; i < times * times; ++i) {
        const glm::u8vec3& p = image.at(times * x + i % times, times * y + i / times);
        sum += glm::vec3(kLinear[p.r], kLinear[p.g], kLinear[p.b]);
      }
      sum *= share;
      small.pixels.emplace_back(byte_of_linear(sum.r), byte_of_linear(sum.g),
                                byte_of_linear(sum.b));
    }
  }
  return small;
}

}  // namespace pointreel
