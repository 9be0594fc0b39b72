#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "codec/files/ply_header.h"
#include "codec/files/read_notes.h"
#include "codec/files/scalar_loss.h"
#include "pointreel/cloud.h"
#include "pointreel/error.h"
#include "pointreel/geometry.h"

/// The vertices of PLY files on their way into a cloud. ply.h says which properties become what.
namespace pointreel {

/// Vertices pass through columns of doubles, a block of rows at a time, so that all formats and
/// types share the code that builds the cloud, and memory grows only with the rows that the data
/// hold.
inline constexpr std::size_t kPlyBlockRows = 512;

/// The values that a vertex may have. A vector takes three consecutive numbers, and each scalar
/// field one.
enum PlyRole : std::size_t {
  kPosition = 0,
  kNormal = 3,
  kColor = 6,
  kRadius = 9,
  kScalar = 10,
  kRoles = kScalar + kMaxScalars
};

using PlyColumn = std::array<double, kPlyBlockRows>;
using PlyBlock = std::array<PlyColumn, kRoles>;

/// For each value, the index of the vertex's property that it is read from, or -1. Packed colours
/// are read from that of kColor alone.
using PlyRoles = std::array<int, kRoles>;

/// Errors: `invalid` if x, y or z is missing.
Result<PlyRoles> assign_roles(const PlyElement& vertex);

/// Whether vertices are Gaussian splats, which have their mean colour as spherical harmonics.
bool is_splat(const PlyElement& vertex);

/// The names of the scalar properties that have no role, in a form that fits into a one-line
/// message. Those of a splat that are numbered stand under one name: f_rest_*.
std::vector<std::string> unread_of(const PlyElement& vertex, const PlyRoles& roles);

/// The inverse of PlyRoles: for each property, the value that it is read into, or kRoles if it is
/// not read. `roles` may be null.
std::vector<PlyRole> roles_by_property(const PlyElement& element, const PlyRoles* roles);

/// Builds a cloud from blocks of rows. Positions in floats and colours in bytes, which most files
/// have, go straight into the cloud. Others are kept until all rows are read: only then are the
/// origin and the value of full brightness known.
class PlyCloudBuilder {
 public:
  /// Reserves memory for `max_rows` rows: pass no more than the file can hold.
  PlyCloudBuilder(const PlyElement& vertex, const PlyRoles& roles, PlyFormat format,
                  std::size_t max_rows);

  void append(const PlyBlock& block, std::size_t rows);
  PointCloud finish(ReadNotes& notes);

 private:
  void grow_box(const PlyBlock& block, std::size_t rows);
  void convert_colors(ReadNotes& notes);
  glm::dvec3 choose_origin() const;

  PointCloud cloud_;
  std::vector<glm::dvec3> positions_;  ///< unless floats hold them
  std::vector<glm::vec3> colors_;      ///< as they are in the file, unless they are bytes
  Box box_;                            ///< of the points that floats can hold
  std::array<PlyType, 3> color_types_{};
  std::vector<ScalarLoss> losses_;  ///< of each scalar field
  bool has_normals_, has_colors_, has_radii_, packed_colors_;
  bool float_positions_ = false, byte_colors_ = true, harmonic_colors_ = false;
};

}  // namespace pointreel
