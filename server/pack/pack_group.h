#pragma once

#include <span>
#include <vector>

#include "pointreel/bytes.h"
#include "pointreel/chunks.h"
#include "pointreel/error.h"
#include "server/pack/pack_frame.h"

namespace pointreel {

/// The chunks of layered depth video of some consecutive frames, which share a cube.
Result<std::vector<Chunks<Bytes>>> pack_group(std::span<const PackedFrame> frames,
                                              const PackOptions& options);

}  // namespace pointreel
