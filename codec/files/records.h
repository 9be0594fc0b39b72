#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "codec/files/byte_source.h"
#include "codec/files/numbers.h"
#include "codec/files/read_notes.h"
#include "codec/files/scalar_loss.h"
#include "pointreel/cloud.h"
#include "pointreel/error.h"

/// Clouds from points that are stored as records of numbers, which most formats are underneath.
namespace pointreel {

/// Where a number of a point is. Row i has it at `offset + i * stride`: numbers of a point that
/// follow each other have the stride of the record, and columns that of their own numbers.
struct RecordField {
  std::size_t offset = 0, stride = 0;
  NumberType type = NumberType::float32;
};
using RecordVector = std::array<RecordField, 3>;

/// A number of a point that is neither position, normal nor colour, as a scalar field of the cloud.
struct RecordScalar {
  std::string name;
  RecordField field;
  std::uint8_t mask = 255;  ///< the bits of an uint8 that count
};

struct RecordLayout {
  RecordVector position;
  /// World coordinates are `scale * number + offset`.
  glm::dvec3 scale{1.0}, offset{0.0};
  std::optional<RecordVector> normal, color;
  /// Red, green and blue in one number of four bytes, from bits 16, 8 and 0. Used without `color`.
  std::optional<RecordField> packed_color;
  std::vector<RecordScalar> scalars;  ///< no more than kMaxScalars
  bool swapped = false;               ///< the numbers are big endian
};

/// Makes a cloud of records, a block at a time.
///
/// Positions of at most 32 bits without scale and offset are relative to 0, unless the largest
/// coordinate by magnitude exceeds twice the longest extent; then they are relative to the minimum
/// corner of the bounding box. Others are relative to the whole coordinates below the middle of the
/// first points if these are far from zero, since floats hold them only near an origin.
///
/// Colours: 8-bit integers v become 257 v; for others, full_color.h says what stands for full
/// brightness. Normals are not normalised.
/// Positions may not be finite: `sanitize` the result.
class RecordCollector {
 public:
  /// Memory for `rows` rows is taken at once, so that they should be known to be there.
  RecordCollector(const RecordLayout& layout, std::size_t rows);
  /// Adds `rows` rows from row `first` of `base` on.
  void add(const std::uint8_t* base, std::size_t first, std::size_t rows);
  PointCloud finish(ReadNotes& notes);

 private:
  enum class Positions : std::uint8_t { floats, scaled };

  void choose_origin(const std::uint8_t* base, std::size_t first, std::size_t rows);
  void add_positions(const std::uint8_t* base, std::size_t first, std::size_t rows);
  void add_normals(const std::uint8_t* base, std::size_t first, std::size_t rows);
  void add_colors(const std::uint8_t* base, std::size_t first, std::size_t rows);
  void add_scalars(const std::uint8_t* base, std::size_t first, std::size_t rows);
  void grow_bounds(std::span<const glm::vec3> positions);
  void move_far_origin();
  void finish_colors(ReadNotes& notes);

  const RecordLayout layout_;
  const Positions positions_;
  bool has_origin_ = false;
  PointCloud cloud_;
  /// Of the finite positions, for Positions::floats.
  glm::vec3 low_{std::numeric_limits<float>::infinity()},
      high_{-std::numeric_limits<float>::infinity()};
  std::vector<glm::vec3> float_colors_;  ///< as they are in the file
  std::uint16_t brightest_ = 0;          ///< of colours with more than 8 bits
  std::vector<ScalarLoss> losses_;       ///< of each scalar field
};

/// Records of `size` bytes, one after another, from byte `begin` of the source on.
struct RecordTable {
  std::uint64_t begin = 0, count = 0;
  std::size_t size = 0;
};

/// Reads a table block by block. The strides of the layout are those of its records. Errors:
/// `invalid` if the source ends before, which `what` names, as in "point"; those of the source.
///
/// Trust: the numbers may be hostile. No memory is taken for records that are not there.
Result<PointCloud> read_records(const ByteSource& source, const RecordTable& table,
                                const RecordLayout& layout, ReadNotes& notes);

}  // namespace pointreel
