#pragma once

#include "client/render/image.h"

namespace pointreel {

/// The picture at a `times`-th of its width and height, which are multiples of it: each pixel is
/// the mean, in linear light, of a square of them.
Image average_squares(const Image& image, int times);

}  // namespace pointreel
