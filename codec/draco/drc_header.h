#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "pointreel/bytes.h"
#include "pointreel/codec.h"
#include "pointreel/error.h"

/// The header of a .drc file, read by a parser of our own before Draco sees the bytes, because
/// Draco allocates memory for any count that it finds. Layout: Draco's bitstream specification,
/// sections "Draco decode" to "Connectivity", and the encodings of older versions, which Draco
/// still reads.
namespace pointreel {

/// A .drc file may declare kFreePoints points, a number of points for each of its bytes, and
/// kFacesPerPoint faces for each point. Real scans take a few bits for each point. At its best,
/// edgebreaker codes a flat grid of a million vertices in 938 bytes, so files that a user chose may
/// have kPointsPerFileByte. Frames in packages and on the network may have only
/// kPointsPerFrameByte; the encoder makes them long enough.
inline constexpr std::uint64_t kFreePoints = 65536;
inline constexpr std::uint64_t kPointsPerFileByte = 1024;
inline constexpr std::uint64_t kPointsPerFrameByte = 64;
inline constexpr std::uint64_t kFacesPerPoint = 4;

/// The number of components that all attributes of a point cloud may have together. Draco's memory
/// for kd-trees grows with its square.
inline constexpr std::uint32_t kMaxComponents = 64;

struct DrcAttribute {
  std::uint8_t type = 0;       ///< draco::GeometryAttribute::Type
  std::uint8_t data_type = 0;  ///< draco::DataType
  std::uint8_t components = 0;
  bool normalized = false;
};

struct DrcHeader {
  std::uint16_t version = 0;   ///< major * 256 + minor
  bool mesh = false;           ///< otherwise a point cloud
  std::uint8_t method = 0;     ///< 0: sequential, 1: edgebreaker (meshes) or kd-tree (clouds)
  bool metadata = false;       ///< whether there is metadata before `body`
  std::size_t body = 0;        ///< offset of the data after header and metadata
  std::uint64_t points = 0;    ///< as declared; for meshes coded by edgebreaker, vertices
  std::uint64_t faces = 0;     ///< meshes only
  std::uint32_t seams = 0;     ///< edgebreaker: the number of attributes that have seams
  int attribute_decoders = 0;  ///< point clouds only
  std::vector<DrcAttribute> attributes;  ///< point clouds only

  static constexpr std::size_t kFixedSize = 11;
};

/// Errors: `unsupported` for an unknown version, geometry type or method, `limit` for counts beyond
/// `limits` or `points_per_byte`, otherwise `invalid`.
///
/// Trust: the bytes may be hostile. Every access is checked, metadata are skipped without
/// recursion, and for kd-trees the second count, inside the coded attributes, must agree with the
/// first. Memory is bounded by the number of bytes.
Result<DrcHeader> parse_drc_header(ByteView bytes, std::uint64_t points_per_byte,
                                   const DecodeLimits& limits);

}  // namespace pointreel
