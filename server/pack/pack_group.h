#pragma once

#include <span>

#include "pointreel/error.h"
#include "server/pack/pack_frame.h"

namespace pointreel {

/// Pixels along the cube, for frames like this one: those of the voxels of the source, or so many
/// that most pixels of a surface have a point.
int pixels_of_side(const PackedFrame& frame);

/// Adds layered depth video to some consecutive frames, which share a cube, as their last layer. A
/// frame that pixels of this cube cannot show is an error, or with PackOptions::best_effort a
/// warning of it.
Result<void> pack_group(std::span<PackedFrame> frames, const PackOptions& options);

}  // namespace pointreel
