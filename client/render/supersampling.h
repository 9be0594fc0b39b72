#pragma once

#include "client/render/image.h"

namespace pointreel {

/// Reduces width and height, which must be multiples of `times`, by that factor. Each pixel is the
/// mean, in linear light, of a square of `times` by `times` pixels.
Image average_squares(const Image& image, int times);

}  // namespace pointreel
