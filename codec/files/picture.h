#pragma once

#include <cstdint>
#include <vector>

#include "pointreel/bytes.h"
#include "pointreel/error.h"

/// Pictures in files: of depth, and of colours.
namespace pointreel {

/// Rows from the top, and values from the left.
struct DepthPicture {
  std::uint32_t width = 0, height = 0;  ///< in pixels, at least 1
  std::vector<std::uint16_t> values;
};

/// Rows from the top; red, green and blue of each pixel in turn.
struct ColorPicture {
  std::uint32_t width = 0, height = 0;  ///< in pixels, at least 1
  Bytes rgb;
};

/// Reads a grey picture of 16 bits: PNG, or PGM as ffmpeg writes it. Errors: `invalid`;
/// `unsupported` for pictures of another kind; `limit` for more than `max_pixels`.
///
/// Trust: the bytes may be hostile. libpng reads only the parts of them that hold the pixels. Time
/// and memory are bounded by `max_pixels`, with a few bytes for each.
Result<DepthPicture> read_depth_picture(ByteView bytes, std::uint64_t max_pixels);

/// Reads a picture of colours: PNG of any kind, JPEG, or PPM as ffmpeg writes it. What is
/// transparent is opaque here. Errors and trust as above; libjpeg-turbo is stopped after 500 passes
/// of a progressive JPEG.
Result<ColorPicture> read_color_picture(ByteView bytes, std::uint64_t max_pixels);

}  // namespace pointreel
