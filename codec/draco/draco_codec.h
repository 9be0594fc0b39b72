#pragma once

#include <vector>

#include "codec/codec.h"

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
Result<DecodedFrame> decode_draco(const std::vector<LayerView>& layers, const DecodeLimits& limits);

/// The parts of a frame that encode_draco made of the same arguments, measured by encoding
/// positions alone, then with colours; what remains is the normals'. The headers count as geometry,
/// and a part that makes the frame no larger counts as 0.
Result<PartSizes> measure_draco_parts(const EncodedFrame& frame, const PointCloud& cloud,
                                      const Cube& cube, const DracoOptions& options, bool normals,
                                      bool colors);

}  // namespace pointreel
