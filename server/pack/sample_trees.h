#pragma once

#include <span>
#include <stop_token>
#include <vector>

#include "codec/files/cloud_file.h"
#include "codec/segments/pack_options.h"
#include "pointreel/error.h"
#include "pointreel/octree.h"

namespace pointreel {

/// Octrees of frames that are spread over the sequence, built exactly as packing builds them, to
/// learn context tables from. These are all frames if there are few small ones; otherwise as many
/// as the time and memory for learning allow, from at most four segments, and at least two if there
/// are two. Runs in the calling arena. The codec must be the octree codec.
Result<std::vector<Svo>> sample_trees(std::span<const CloudFrame> files, const PackOptions& options,
                                      const std::stop_token& stop);

}  // namespace pointreel
