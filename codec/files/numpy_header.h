#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "codec/files/numbers.h"
#include "pointreel/bytes.h"
#include "pointreel/error.h"

namespace pointreel {

/// The numbers of one name in each item of an array.
struct NumpyColumn {
  std::string name;        ///< empty unless the array is structured
  std::size_t offset = 0;  ///< in the item, in bytes
  std::size_t count = 1;   ///< of numbers
  bool readable = true;    ///< no text, object, complex number or time
  bool object = false;     ///< of Python
  NumberType type = NumberType::float32;
  std::size_t size = 4;  ///< of one of them, in bytes; 2 for half floats, whose type is float32
  bool swapped = false;  ///< big endian
};

/// What stands before the items of an array.
struct NumpyHeader {
  std::vector<NumpyColumn> columns;  ///< one, unless the array is structured
  std::size_t item_size = 0;         ///< in bytes
  bool by_columns = false;           ///< as Fortran has arrays: the first index varies fastest
  std::vector<std::uint64_t> shape;
  std::size_t begin = 0;  ///< where the items are, from the first byte of the header

  /// With objects in some column, numpy pickles the whole array: there are no items.
  bool is_pickled() const;
  std::string shape_text() const;  ///< "(100, 3)"
};

/// The longest header that is read, in bytes.
inline constexpr std::size_t kNumpyHeader = std::size_t{64} << 10;

/// Reads the header that `bytes` begin with. Errors: `invalid`, without the array's name.
///
/// Trust: the bytes may be hostile.
Result<NumpyHeader> read_numpy_header(ByteView bytes);

}  // namespace pointreel
