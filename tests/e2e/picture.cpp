#include "tests/e2e/picture.h"

#include <algorithm>
#include <cstddef>

#include <png.h>

namespace pointreel::e2e {

Picture read_picture(const std::filesystem::path& png) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_file(&image, png.c_str()) == 0) return {};
  image.format = PNG_FORMAT_RGB;
  Picture picture;
  picture.size = {static_cast<int>(image.width), static_cast<int>(image.height)};
  picture.pixels.resize(std::size_t{image.width} * image.height);
  if (png_image_finish_read(&image, nullptr, picture.pixels.data(), 0, nullptr) == 0) return {};
  return picture;
}

Picture rows(const Picture& picture, int top, int bottom) {
  const auto at = [&](int row) {
    return picture.pixels.begin() + std::ptrdiff_t{row} * picture.size.x;
  };
  return {{picture.size.x, bottom - top}, {at(top), at(bottom)}};
}

Patch find_hue(const Picture& picture, const glm::ivec3& bright) {
  Patch patch;
  for (int y = 0; y < picture.size.y; ++y) {
    for (int x = 0; x < picture.size.x; ++x) {
      const glm::ivec3 c(picture.at(x, y));
      const int most = std::max({c.r, c.g, c.b});
      bool matches = most > 60;
      for (int i = 0; i < 3; ++i) matches = matches && (c[i] * 2 > most) == (bright[i] == 1);
      if (!matches) continue;
      ++patch.pixels;
      patch.center += glm::dvec2(x, y);
    }
  }
  if (patch.pixels > 0) patch.center /= static_cast<double>(patch.pixels);
  return patch;
}

}  // namespace pointreel::e2e
