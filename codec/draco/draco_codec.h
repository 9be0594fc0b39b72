#pragma once

#include <vector>

#include "pointreel/chunks.h"
#include "pointreel/draco.h"

/// The Draco codec. A frame has one layer, whose geometry consists of the common headers
/// (frame_header.h) and a chunk with the Draco payload (draco_payload.h), which holds all
/// attributes. FORMAT.md, "Draco frames".
///
/// Trust: decoding takes hostile bytes. Headers and checksums are checked first, then the payload
/// as described in draco_payload.h, and finally that payload and header agree on points and
/// attributes.
namespace pointreel {

Result<EncodedFrame> encode_draco(const PointCloud& cloud, const Cube& cube,
                                  const DracoOptions& options, bool normals, bool colors);

/// The points are in no particular order and include duplicates. There is no tree.
Result<DecodedFrame> decode_draco(const std::vector<Chunks<ByteView>>& layers,
                                  const DecodeLimits& limits);

}  // namespace pointreel
