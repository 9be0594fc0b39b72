#pragma once

#include <span>

#include "codec/video/video_group.h"
#include "codec/video_encode/view_layers.h"

namespace pointreel {

/// Sets the group's patches: for each layer that a frame uses, the rectangle that holds its pixels
/// in all frames, and a place for it in pictures that are as small as a simple search finds. Sets
/// the size of the pictures, too.
void place_patches(std::span<const ViewLayers> frames, VideoGroup& group);

}  // namespace pointreel
