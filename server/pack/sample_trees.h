#pragma once

#include <filesystem>
#include <span>
#include <stop_token>
#include <vector>

#include "pointreel/error.h"
#include "pointreel/octree.h"
#include "server/pack/pack_options.h"

namespace pointreel {

/// Trees of frames spread over the sequence, exactly as packing makes them: of all frames where
/// they are few and small, otherwise of so many as time and memory for learning from them allow,
/// two at least where there are two, out of four segments at most. Runs in the calling arena. The
/// octree codec's options are those that count.
Result<std::vector<Svo>> sample_trees(std::span<const std::filesystem::path> files,
                                      const PackOptions& options, const std::stop_token& stop);

}  // namespace pointreel
