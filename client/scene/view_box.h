#pragma once

#include "client/scene/frame.h"
#include "pointreel/cloud.h"

namespace pointreel {

/// The box that the first view of a source frames, for the bounds of all its frames and the boxes
/// of the first one that is shown: the bounds, unless a few stray points of that frame make them
/// much larger than the rest of it, or the frame would be a speck in them.
Box view_box(const Box& bounds, const FrameBoxes& first);

}  // namespace pointreel
