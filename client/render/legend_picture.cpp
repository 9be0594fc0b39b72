#include "client/render/legend_picture.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <string>

#include <stb/stb_easy_font.h>

#include "client/scene/scalar_colors.h"
#include "common/base/characters.h"

namespace pointreel {
namespace {

// In units of a pixel of the font, whose letters are about 6 wide and 8 high.
constexpr int kLine = 12, kMargin = 8, kPad = 5, kRampWidth = 120, kRampHeight = 8, kSwatch = 8;
constexpr glm::u8vec3 kPaper{24, 26, 30}, kInk{235, 235, 235};
constexpr int kReferenceHeight = 540;  ///< of a picture in which a unit is a pixel

std::string ascii(std::string_view text) {
  std::string plain;
  while (!text.empty()) {
    const Character character = first_character(text);
    plain += character.bytes == 1 ? text.front() : '?';
    text.remove_prefix(std::max<std::size_t>(character.bytes, 1));
  }
  return plain;
}

int width_of(const std::string& text) {
  return stb_easy_font_width(const_cast<char*>(text.c_str()));
}

/// Draws in units of `scale` pixels, from a corner of the picture on.
class Pen {
 public:
  Pen(Image& image, glm::ivec2 corner, int scale) : image_(image), corner_(corner), scale_(scale) {}

  void fill(glm::ivec2 from, glm::ivec2 to, const glm::u8vec3& color) const {
    const glm::ivec2 size(image_.width, image_.height);
    const glm::ivec2 first = glm::clamp(corner_ + scale_ * from, glm::ivec2(0), size);
    const glm::ivec2 end = glm::clamp(corner_ + scale_ * to, glm::ivec2(0), size);
    for (int y = first.y; y < end.y; ++y) {
      const auto row = image_.pixels.begin() + std::ptrdiff_t{y} * image_.width;
      std::fill(row + first.x, std::max(row + first.x, row + end.x), color);
    }
  }

  void write(glm::ivec2 at, const std::string& text) const {
    struct Vertex {
      float x, y, z;
      std::uint32_t color;
    };
    std::vector<std::array<Vertex, 4>> quads(16 * text.size() + 16);
    const int count =
        stb_easy_font_print(0.0f, 0.0f, const_cast<char*>(text.c_str()), nullptr, quads.data(),
                            static_cast<int>(quads.size() * sizeof(quads[0])));
    for (int i = 0; i < count; ++i) {
      const auto& quad = quads[static_cast<std::size_t>(i)];
      fill(at + glm::ivec2(glm::vec2(quad[0].x, quad[0].y)),
           at + glm::ivec2(glm::vec2(quad[2].x, quad[2].y)), kInk);
    }
  }

 private:
  Image& image_;
  glm::ivec2 corner_;
  int scale_;
};

}  // namespace

void draw_legend(const Legend& legend, Image& image) {
  const std::string title = ascii(legend.title);
  int width = std::max(kRampWidth, width_of(title));
  if (!legend.labels.empty()) width = std::max(width_of(title), 40);
  const int lines = legend.labels.empty() ? 1 : static_cast<int>(legend.labels.size());
  const int body = legend.labels.empty() ? kRampHeight + 2 + kLine : lines * kLine;
  const glm::ivec2 size(width + 2 * kPad, kLine + body + 2 * kPad);
  const int scale = std::max(1, image.height / kReferenceHeight);
  if ((size.x + 2 * kMargin) * scale > image.width || (size.y + 2 * kMargin) * scale > image.height)
    return;
  const Pen pen(image, {kMargin * scale, image.height - (kMargin + size.y) * scale}, scale);
  pen.fill({0, 0}, size, kPaper);
  pen.write({kPad, kPad}, title);
  int y = kPad + kLine;
  if (legend.labels.empty()) {
    for (int x = 0; x < width; ++x)
      pen.fill({kPad + x, y}, {kPad + x + 1, y + kRampHeight},
               ramp_color(x / static_cast<double>(width - 1)));
    y += kRampHeight + 3;
    pen.write({kPad, y}, legend.least);
    pen.write({kPad + width - width_of(legend.most), y}, legend.most);
  }
  for (const auto& [color, label] : legend.labels) {
    pen.fill({kPad, y}, {kPad + kSwatch, y + kSwatch}, color);
    pen.write({kPad + kSwatch + 4, y}, label);
    y += kLine;
  }
}

}  // namespace pointreel
