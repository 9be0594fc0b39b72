#include "codec/files/picture.h"

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <memory>
#include <optional>
#include <string_view>

#include <turbojpeg.h>

#include "codec/files/numbers.h"
#include "codec/files/ply_header.h"
#include "codec/files/png_picture.h"
#include "common/base/concat.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

Result<void> check_size(std::uint64_t width, std::uint64_t height, std::uint64_t max_pixels) {
  if (width == 0 || height == 0) return fail("has no pixels");
  if (width > max_pixels || height > max_pixels || width * height > max_pixels) {
    return fail(ErrorCode::limit, concat("has ", width, " x ", height, " pixels; at most ",
                                         max_pixels, " are accepted"));
  }
  return {};
}

/// A picture of netpbm without comments, as ffmpeg writes it.
struct Netpbm {
  std::uint32_t width = 0, height = 0, most = 0;
  ByteView pixels;
};

/// Nothing if the bytes do not begin with `kind`, "P5" or "P6".
std::optional<Netpbm> netpbm(ByteView bytes, std::string_view kind) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (!text.starts_with(kind)) return std::nullopt;
  Netpbm picture;
  std::size_t at = kind.size();
  for (std::uint32_t* number : {&picture.width, &picture.height, &picture.most}) {
    while (at < text.size() && (text[at] == ' ' || text[at] == '\n')) ++at;
    const auto read = std::from_chars(text.data() + at, text.data() + text.size(), *number);
    if (read.ec != std::errc()) return std::nullopt;
    at = static_cast<std::size_t>(read.ptr - text.data());
  }
  if (at < text.size()) picture.pixels = bytes.subspan(at + 1);
  return picture;
}

Result<DepthPicture> read_pgm(const Netpbm& from, std::uint64_t max_pixels) {
  TRY(check_size(from.width, from.height, max_pixels));
  if (from.most != 65535)
    return fail(ErrorCode::unsupported, "is a PGM file of other than 16 bits");
  DepthPicture picture{from.width, from.height, {}};
  const std::size_t count = std::size_t{from.width} * from.height;
  if (from.pixels.size() / 2 < count) return fail("ends within its pixels");
  picture.values.resize(count);
  for (std::size_t i = 0; i < count; ++i)
    picture.values[i] = load_number<std::uint16_t, true>(from.pixels.data() + 2 * i);
  return picture;
}

Result<ColorPicture> read_ppm(const Netpbm& from, std::uint64_t max_pixels) {
  TRY(check_size(from.width, from.height, max_pixels));
  if (from.most != 255) return fail(ErrorCode::unsupported, "is a PPM file of other than 8 bits");
  const std::size_t size = 3 * std::size_t{from.width} * from.height;
  if (from.pixels.size() < size) return fail("ends within its pixels");
  return ColorPicture{from.width, from.height,
                      Bytes(from.pixels.begin(), from.pixels.begin() + std::ptrdiff_t(size))};
}

bool is_jpeg(ByteView bytes) {
  return bytes.size() >= 3 && bytes[0] == 0xff && bytes[1] == 0xd8 && bytes[2] == 0xff;
}

Result<ColorPicture> read_jpeg(ByteView bytes, std::uint64_t max_pixels) {
  struct Destroy {
    void operator()(void* jpeg) const { tjDestroy(jpeg); }
  };
  const std::unique_ptr<void, Destroy> jpeg(tjInitDecompress());
  if (jpeg == nullptr) return fail(ErrorCode::limit, "out of memory");
  const auto failed = [&] {
    return fail(concat("is not a readable JPEG file: ", printable(tjGetErrorStr2(jpeg.get()))));
  };
  const auto size = static_cast<unsigned long>(bytes.size());
  int width = 0, height = 0, sampling = 0, space = 0;
  if (tjDecompressHeader3(jpeg.get(), bytes.data(), size, &width, &height, &sampling, &space) != 0)
    return failed();
  TRY(check_size(static_cast<std::uint64_t>(width), static_cast<std::uint64_t>(height),
                 max_pixels));
  ColorPicture picture{static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height), {}};
  picture.rgb.resize(3 * std::size_t{picture.width} * picture.height);
  if (tjDecompress2(jpeg.get(), bytes.data(), size, picture.rgb.data(), width, 0, height, TJPF_RGB,
                    TJFLAG_LIMITSCANS) == 0)
    return picture;
  // Cameras leave bytes between their parts, which only gives a warning. So does what is cut off,
  // but the rest of the picture would be grey.
  const std::string_view why = tjGetErrorStr2(jpeg.get());
  if (tjGetErrorCode(jpeg.get()) == TJERR_FATAL || why.find("Premature end") != why.npos)
    return failed();
  return picture;
}

}  // namespace

Result<DepthPicture> read_depth_picture(ByteView bytes, std::uint64_t max_pixels) {
  if (is_png(bytes)) return read_depth_png(bytes, max_pixels);
  if (const auto pgm = netpbm(bytes, "P5")) return read_pgm(*pgm, max_pixels);
  return fail(is_jpeg(bytes) ? "is a JPEG file, which loses depth; it must be PNG"
                             : "is not a PNG file");
}

Result<ColorPicture> read_color_picture(ByteView bytes, std::uint64_t max_pixels) {
  if (is_png(bytes)) return read_color_png(bytes, max_pixels);
  if (is_jpeg(bytes)) return read_jpeg(bytes, max_pixels);
  if (const auto ppm = netpbm(bytes, "P6")) return read_ppm(*ppm, max_pixels);
  return fail("is neither a PNG nor a JPEG file");
}

}  // namespace pointreel
