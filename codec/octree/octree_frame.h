#pragma once

#include "codec/octree/attribute_coder.h"
#include "codec/octree/chunk_payload.h"
#include "codec/octree/frame_header.h"
#include "codec/octree/value_arrays.h"

/// What the encoder and the decoder of octree frames agree on. FORMAT.md, "Octree frames".
namespace pointreel {

/// The numbers of an attribute that is stored exactly.
inline constexpr CodeShape kNormalShape{2, 8};
inline CodeShape color_shape(const FrameHeader& header) {
  return {3, header.colors_16_bit ? 16 : 8};
}

/// Of a chunk of colours or normals that are transformed.
inline AttributeKind attribute_of(ChunkKind kind) {
  return kind == ChunkKind::normals ? AttributeKind::normals : AttributeKind::colors;
}

}  // namespace pointreel
