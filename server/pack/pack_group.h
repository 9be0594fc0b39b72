#pragma once

#include <span>
#include <vector>

#include "pointreel/bytes.h"
#include "pointreel/chunks.h"
#include "pointreel/error.h"
#include "server/pack/pack_frame.h"

namespace pointreel {

/// The chunks of layered depth video of some consecutive frames, which share a cube. A frame that
/// pixels of this cube cannot show is an error, or with PackOptions::best_effort a warning of it.
Result<std::vector<Chunks<Bytes>>> pack_group(std::span<PackedFrame> frames,
                                              const PackOptions& options);

}  // namespace pointreel
