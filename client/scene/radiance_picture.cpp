#include "client/scene/radiance_picture.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/try.h"

namespace pointreel {
namespace {

constexpr std::size_t kLongestLine = 1024;
constexpr int kMostHeaderLines = 256;
constexpr int kLeastHeight = 2;

/// The texels of a row, one component after another.
using Row = std::vector<std::uint8_t>;

tl::unexpected<Error> cut_off(int row) {
  return fail(ErrorCode::invalid, "the picture ends within row " + std::to_string(row));
}

class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  std::optional<std::string_view> line() {
    const std::size_t most = std::min(kLongestLine, bytes_.size());
    const auto end = std::find(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(most),
                               std::uint8_t{'\n'});
    const auto length = static_cast<std::size_t>(end - bytes_.begin());
    if (length == most) return std::nullopt;
    const std::string_view text(reinterpret_cast<const char*>(bytes_.data()), length);
    bytes_ = bytes_.subspan(length + 1);
    return text;
  }

  Result<void> row(int number, int width, Row& to) {
    const auto texels = static_cast<std::size_t>(width);
    if (bytes_.size() >= 4 && width >= 8 && width < 32768 && bytes_[0] == 2 && bytes_[1] == 2 &&
        (bytes_[2] << 8 | bytes_[3]) == width) {
      bytes_ = bytes_.subspan(4);
      return encoded_row(number, to);
    }
    if (bytes_.size() < 4 * texels) return cut_off(number);
    for (std::size_t i = 0; i < texels; ++i)
      for (std::size_t part = 0; part < 4; ++part) to[part * texels + i] = bytes_[4 * i + part];
    for (std::size_t i = 0; i < texels; ++i)
      if (to[i] == 1 && to[texels + i] == 1 && to[2 * texels + i] == 1)
        return fail(ErrorCode::unsupported, "row " + std::to_string(number) +
                                                " has the run-length encoding of 1985; save the "
                                                "picture again with any newer program");
    bytes_ = bytes_.subspan(4 * texels);
    return {};
  }

 private:
  Result<void> encoded_row(int number, Row& to) {
    for (std::size_t part = 0; part < 4; ++part) {
      const std::size_t end = (part + 1) * to.size() / 4;
      for (std::size_t at = part * to.size() / 4; at < end;) {
        if (bytes_.size() < 2) return cut_off(number);
        const bool run = bytes_[0] > 128;
        const std::size_t count = run ? bytes_[0] - 128u : bytes_[0];
        if (count == 0 || count > end - at)
          return fail(ErrorCode::invalid,
                      "row " + std::to_string(number) + " does not fit the width");
        if (run) {
          std::fill_n(to.begin() + static_cast<std::ptrdiff_t>(at), count, bytes_[1]);
          bytes_ = bytes_.subspan(2);
        } else {
          if (bytes_.size() < 1 + count) return cut_off(number);
          std::copy_n(bytes_.begin() + 1, count, to.begin() + static_cast<std::ptrdiff_t>(at));
          bytes_ = bytes_.subspan(1 + count);
        }
        at += count;
      }
    }
    return {};
  }

  std::span<const std::uint8_t> bytes_;
};

struct Size {
  int width, height;
};

std::string pixels(int width, int height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

Result<Size> parse_size(std::string_view line) {
  int width = 0, height = 0;
  char end = 0;
  const std::string text(line);
  if (std::sscanf(text.c_str(), "-Y %9d +X %9d%c", &height, &width, &end) != 2)
    return fail(ErrorCode::unsupported,
                "the line of the size is not \"-Y HEIGHT +X WIDTH\", for rows from the top");
  if (height < kLeastHeight || width < 2 * kLeastHeight || width > kMostRadianceWidth ||
      height > kMostRadianceWidth / 2)
    return fail(ErrorCode::limit, pixels(width, height) + " pixels: 4x2 to " +
                                      pixels(kMostRadianceWidth, kMostRadianceWidth / 2) +
                                      " can be read");
  return Size{width, height};
}

Result<Size> parse_header(Reader& reader) {
  const auto first = reader.line();
  if (!first || !first->starts_with("#?"))
    return fail(ErrorCode::invalid, "is not a picture in Radiance's format (.hdr)");
  bool rgbe = false;
  for (int i = 0; i < kMostHeaderLines; ++i) {
    const auto line = reader.line();
    if (!line) break;
    if (line->empty()) {
      if (!rgbe) break;
      const auto size = reader.line();
      if (!size) break;
      return parse_size(*size);
    }
    if (line->starts_with("FORMAT=")) {
      if (*line != "FORMAT=32-bit_rle_rgbe")
        return fail(ErrorCode::unsupported, "its format is not 32-bit_rle_rgbe");
      rgbe = true;
    }
  }
  return fail(ErrorCode::invalid, "its header has no end, or no FORMAT=32-bit_rle_rgbe");
}

/// Light is relative, so whatever scale the exponent has is right; it is bounded so that sums are
/// finite.
glm::vec3 light_of(const Row& row, std::size_t i) {
  const std::size_t texels = row.size() / 4;
  const int exponent = row[3 * texels + i];
  if (exponent == 0) return glm::vec3(0.0f);
  const float scale = std::ldexp(1.0f, std::clamp(exponent - 136, -60, 40));
  return scale * glm::vec3(row[i], row[texels + i], row[2 * texels + i]);
}

}  // namespace

Result<EnvironmentMap> parse_radiance(std::span<const std::uint8_t> bytes) {
  Reader reader(bytes);
  const Size size = TRY(parse_header(reader));
  const int edge = (size.height + kMostEnvironmentRows - 1) / kMostEnvironmentRows;
  EnvironmentMap map{(size.width + edge - 1) / edge, (size.height + edge - 1) / edge, {}};
  std::vector<glm::vec3> sums(static_cast<std::size_t>(map.width));
  Row row(4 * static_cast<std::size_t>(size.width));
  for (int y = 0; y < size.height; ++y) {
    TRY(reader.row(y, size.width, row));
    for (std::size_t x = 0; x < static_cast<std::size_t>(size.width); ++x)
      sums[x / static_cast<std::size_t>(edge)] += light_of(row, x);
    if ((y + 1) % edge != 0 && y + 1 != size.height) continue;
    const int rows = y % edge + 1;
    for (int x = 0; x < map.width; ++x) {
      const int columns = std::min(edge, size.width - x * edge);
      map.texels.push_back(sums[static_cast<std::size_t>(x)] / static_cast<float>(rows * columns));
    }
    std::fill(sums.begin(), sums.end(), glm::vec3(0.0f));
  }
  return map;
}

}  // namespace pointreel
