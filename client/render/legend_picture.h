#pragma once

#include "client/render/image.h"
#include "client/scene/legend.h"

namespace pointreel {

/// Draws a legend into the lower left corner of a picture, unless that is smaller than it. Letters
/// beyond ASCII become "?".
void draw_legend(const Legend& legend, Image& image);

}  // namespace pointreel
