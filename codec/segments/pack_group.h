#pragma once

#include <span>

#include "codec/segments/pack_frame.h"
#include "pointreel/error.h"

namespace pointreel {

/// Adds layered depth video to some consecutive frames, which share a cube, as their last layer. A
/// frame that pixels of this cube cannot show is an error, or with PackOptions::best_effort a
/// warning of it.
Result<void> pack_group(std::span<PackedFrame> frames, const PackOptions& options);

}  // namespace pointreel
