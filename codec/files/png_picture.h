#pragma once

#include <cstdint>

#include "codec/files/picture.h"

namespace pointreel {

bool is_png(ByteView bytes);

/// As read_depth_picture and read_color_picture, of PNG only.
///
/// Trusts nothing: any bytes give a picture of at most `max_pixels` or an error.
Result<DepthPicture> read_depth_png(ByteView bytes, std::uint64_t max_pixels);
Result<ColorPicture> read_color_png(ByteView bytes, std::uint64_t max_pixels);

}  // namespace pointreel
