#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "pointreel/bytes.h"
#include "pointreel/codec.h"
#include "pointreel/error.h"

/// What a .drc file says of itself, read by our own parser before Draco sees the bytes: Draco takes
/// memory for counts as it finds them. Layout: Draco's bitstream specification, sections "Draco
/// decode" to "Connectivity", and the encodings of older versions, which Draco still reads.
namespace pointreel {

/// How many points a .drc may declare: kFreePoints and so many for each of its bytes, and of faces
/// four times as many. Real scans take a few bits a point; what edgebreaker does best, a flat grid
/// of a million vertices, takes 938 bytes, so files of the user's may have that. Frames in packages
/// and on the wire may not: the encoder sees to it that theirs are long enough.
inline constexpr std::uint64_t kFreePoints = 65536;
inline constexpr std::uint64_t kPointsPerFileByte = 1024;
inline constexpr std::uint64_t kPointsPerFrameByte = 64;
inline constexpr std::uint64_t kFacesPerPoint = 4;

/// Components a point that all attributes of a point cloud may have together; Draco's memory for
/// kd-trees grows with the square.
inline constexpr std::uint32_t kMaxComponents = 64;

struct DrcAttribute {
  std::uint8_t type = 0;       ///< draco::GeometryAttribute::Type
  std::uint8_t data_type = 0;  ///< draco::DataType
  std::uint8_t components = 0;
  bool normalized = false;
};

struct DrcHeader {
  std::uint16_t version = 0;   ///< major * 256 + minor
  bool mesh = false;           ///< else a point cloud
  std::uint8_t method = 0;     ///< 0: sequential, 1: edgebreaker (meshes) or kd-tree (clouds)
  bool metadata = false;       ///< there is some, between the fixed header and `body`
  std::size_t body = 0;        ///< offset of what follows header and metadata
  std::uint64_t points = 0;    ///< declared points; meshes by edgebreaker: vertices
  std::uint64_t faces = 0;     ///< meshes only
  int attribute_decoders = 0;  ///< point clouds only
  std::vector<DrcAttribute> attributes;  ///< point clouds only

  static constexpr std::size_t kFixedSize = 11;
};

/// Trusts nothing: every byte is bounds-checked, metadata is stepped over without recursion, counts
/// beyond `limits` and `points_per_byte` are refused, and for kd-trees the second count, inside the
/// coded attributes, must agree with the first. Memory is bounded by the bytes given.
Result<DrcHeader> parse_drc_header(ByteView bytes, std::uint64_t points_per_byte,
                                   const DecodeLimits& limits);

}  // namespace pointreel
