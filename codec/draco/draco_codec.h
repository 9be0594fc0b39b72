#pragma once

#include <vector>

#include "pointreel/chunks.h"
#include "pointreel/draco.h"

/// The Draco codec: a frame of one layer, whose geometry holds the common headers (frame_header.h)
/// and one chunk with the Draco payload (draco_payload.h), all attributes in it. FORMAT.md, "Draco
/// frames".
///
/// Trust: decoding takes hostile bytes. Headers and checksums are checked first, the payload as
/// draco_payload.h says, and then that payload and header agree on points and attributes.
namespace pointreel {

Result<EncodedFrame> encode_draco(const PointCloud& cloud, const Cube& cube,
                                  const DracoOptions& options, bool normals, bool colors);

/// Points in no particular order; duplicates as they were given. There is no tree.
Result<DecodedFrame> decode_draco(const std::vector<Chunks<ByteView>>& layers,
                                  const DecodeLimits& limits);

}  // namespace pointreel
