#include "codec/files/ply.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "codec/files/ply_cloud_builder.h"
#include "codec/files/ply_header.h"
#include "common/base/concat.h"
#include "common/base/parse_number.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

/// The smallest possible number of bytes of a row, which is that of a row whose lists are empty.
std::size_t min_row_size(const PlyElement& element, PlyFormat format) {
  std::size_t size = 0;
  for (const PlyProperty& property : element.properties) {
    // In ascii, a value takes at least one character and a separator.
    size += format == PlyFormat::ascii ? 2
            : property.is_list         ? size_of(property.count_type)
                                       : size_of(property.type);
  }
  return size;
}

std::string name_row(const PlyElement& element, std::uint64_t row) {
  return concat(printable(element.name), " ", row, " of ", element.count);
}

template <class T, bool kSwap>
T load(const std::uint8_t* at) {
  std::array<std::uint8_t, sizeof(T)> bytes;
  std::memcpy(bytes.data(), at, sizeof(T));
  if constexpr (kSwap) std::reverse(bytes.begin(), bytes.end());
  return std::bit_cast<T>(bytes);
}

/// Calls `f` with a value of the C++ type that corresponds to `type`.
template <class F>
auto with_type(PlyType type, F&& f) {
  switch (type) {
    case PlyType::int8:
      return f(std::int8_t{});
    case PlyType::uint8:
      return f(std::uint8_t{});
    case PlyType::int16:
      return f(std::int16_t{});
    case PlyType::uint16:
      return f(std::uint16_t{});
    case PlyType::int32:
      return f(std::int32_t{});
    case PlyType::uint32:
      return f(std::uint32_t{});
    case PlyType::float32:
      return f(float{});
    default:
      return f(double{});
  }
}

/// Reads the elements of a binary file one after another.
template <bool kSwap>
class BinaryBody {
 public:
  BinaryBody(ByteView bytes, const PlyHeader& header) : bytes_(bytes), at_(header.size) {}

  Result<void> skip(const PlyElement& element) {
    if (has_lists(element)) return walk(element, nullptr, nullptr);
    return take_rows(element, min_row_size(element, PlyFormat::little_endian)).map([](auto) {});
  }

  Result<void> read(const PlyElement& vertex, const PlyRoles& roles, PlyCloudBuilder& builder) {
    if (has_lists(vertex)) return walk(vertex, &roles, &builder);
    const std::size_t row_size = min_row_size(vertex, PlyFormat::little_endian);
    const std::uint8_t* const rows = TRY(take_rows(vertex, row_size));
    PlyBlock block;
    for (std::uint64_t row = 0; row < vertex.count; row += kPlyBlockRows) {
      const std::size_t n = std::min<std::uint64_t>(kPlyBlockRows, vertex.count - row);
      for (std::size_t role = 0; role < kRoles; ++role) {
        if (roles[role] < 0) continue;
        const auto property = static_cast<std::size_t>(roles[role]);
        const std::uint8_t* from = rows + row * row_size + offset(vertex, property);
        double* column = block[role].data();
        with_type(vertex.properties[property].type, [=](auto type) {
          for (std::size_t i = 0; i < n; ++i) {
            column[i] = static_cast<double>(load<decltype(type), kSwap>(from + i * row_size));
          }
        });
      }
      builder.append(block, n);
    }
    return {};
  }

  /// Whether there seem to be further rows of an element.
  bool has_more(const PlyElement& element) const {
    const std::size_t rest = bytes_.size() - at_;
    return !has_lists(element) && rest > 0 &&
           rest % min_row_size(element, PlyFormat::little_endian) == 0;
  }

 private:
  static bool has_lists(const PlyElement& element) {
    return std::any_of(element.properties.begin(), element.properties.end(),
                       [](const PlyProperty& property) { return property.is_list; });
  }

  static std::size_t offset(const PlyElement& element, std::size_t property) {
    std::size_t sum = 0;
    for (std::size_t i = 0; i < property; ++i) sum += size_of(element.properties[i].type);
    return sum;
  }

  tl::unexpected<Error> ends_within(const PlyElement& element, std::uint64_t row,
                                    const PlyProperty& property) const {
    return fail(concat("byte ", bytes_.size(), ": the data end within property ",
                       printable(property.name), " of ", name_row(element, row)));
  }

  /// Steps over all rows of an element without lists and returns their first byte.
  Result<const std::uint8_t*> take_rows(const PlyElement& element, std::size_t row_size) {
    const std::uint8_t* begin = bytes_.data() + at_;
    const std::size_t rest = bytes_.size() - at_;
    if (row_size == 0) return begin;
    const std::size_t rows = rest / row_size;
    if (element.count > rows) {
      std::size_t property = 0;
      for (std::size_t left = rest % row_size; left >= size_of(element.properties[property].type);
           ++property) {
        left -= size_of(element.properties[property].type);
      }
      return ends_within(element, rows, element.properties[property]);
    }
    at_ += element.count * row_size;
    return begin;
  }

  /// Reads an element row by row and passes its values to `builder`, unless that is null.
  Result<void> walk(const PlyElement& element, const PlyRoles* roles, PlyCloudBuilder* builder) {
    const std::vector<PlyRole> role_of = roles_by_property(element, roles);
    PlyBlock block;
    std::size_t filled = 0;
    for (std::uint64_t row = 0; row < element.count; ++row) {
      for (std::size_t i = 0; i < element.properties.size(); ++i) {
        const PlyProperty& property = element.properties[i];
        double value = 0.0;
        if (!take(property.is_list ? property.count_type : property.type, value)) {
          return ends_within(element, row, property);
        }
        if (property.is_list) {
          if (value < 0.0) {
            return fail(concat("byte ", at_, ": the list ", printable(property.name), " of ",
                               name_row(element, row), " has a negative length"));
          }
          const std::uint64_t size = static_cast<std::uint64_t>(value) * size_of(property.type);
          if (size > bytes_.size() - at_) return ends_within(element, row, property);
          at_ += size;
        }
        if (role_of[i] != kRoles) block[role_of[i]][filled] = value;
      }
      if (builder != nullptr && (++filled == kPlyBlockRows || row + 1 == element.count)) {
        builder->append(block, filled);
        filled = 0;
      }
    }
    return {};
  }

  bool take(PlyType type, double& value) {
    if (bytes_.size() - at_ < size_of(type)) return false;
    const std::uint8_t* from = bytes_.data() + at_;
    value = with_type(
        type, [from](auto t) { return static_cast<double>(load<decltype(t), kSwap>(from)); });
    at_ += size_of(type);
    return true;
  }

  ByteView bytes_;
  std::size_t at_;
};

/// Reads the elements of an ascii file one after another. Values may be separated by blanks or line
/// breaks alike.
class AsciiBody {
 public:
  AsciiBody(ByteView bytes, const PlyHeader& header)
      : at_(reinterpret_cast<const char*>(bytes.data()) + header.size),
        end_(reinterpret_cast<const char*>(bytes.data()) + bytes.size()),
        line_end_(header.line_end),
        line_(header.lines + 1) {}

  Result<void> skip(const PlyElement& element) { return walk(element, nullptr, nullptr); }

  Result<void> read(const PlyElement& vertex, const PlyRoles& roles, PlyCloudBuilder& builder) {
    return walk(vertex, &roles, &builder);
  }

  /// Whether there seem to be further rows of an element.
  bool has_more(const PlyElement& element) {
    double ignored = 0.0;
    return !element.properties.empty() &&
           std::all_of(element.properties.begin(), element.properties.end(),
                       [&](const PlyProperty&) { return parse_number(take_word(), ignored); });
  }

 private:
  Result<void> walk(const PlyElement& element, const PlyRoles* roles, PlyCloudBuilder* builder) {
    if (element.properties.empty()) return {};
    const std::vector<PlyRole> role_of = roles_by_property(element, roles);
    PlyBlock block;
    std::size_t filled = 0;
    for (std::uint64_t row = 0; row < element.count; ++row) {
      for (std::size_t i = 0; i < element.properties.size(); ++i) {
        const PlyProperty& property = element.properties[i];
        std::string_view word = take_word();
        if (word.empty()) return ends_within(element, row, property);
        // Values that are not needed are skipped unparsed. The length of a list is always needed.
        if (role_of[i] == kRoles && !property.is_list) continue;
        double value = 0.0;
        if (!parse_number(word, value)) {
          if (property.is_list || role_of[i] < kScalar) {
            return fail(concat("line ", line_, ": property ", printable(property.name), " of ",
                               name_row(element, row), " is '", printable(word),
                               "', which is not a number"));
          }
          value = std::numeric_limits<double>::quiet_NaN();
        }
        if (property.is_list) {
          if (!(value >= 0.0)) {
            return fail(concat("line ", line_, ": the list ", printable(property.name), " of ",
                               name_row(element, row), " has the length '", printable(word), "'"));
          }
          for (double entry = 0.0; entry < value; ++entry) {
            if (take_word().empty()) return ends_within(element, row, property);
          }
        }
        if (role_of[i] != kRoles) block[role_of[i]][filled] = value;
      }
      if (builder != nullptr && (++filled == kPlyBlockRows || row + 1 == element.count)) {
        builder->append(block, filled);
        filled = 0;
      }
    }
    return {};
  }

  tl::unexpected<Error> ends_within(const PlyElement& element, std::uint64_t row,
                                    const PlyProperty& property) const {
    return fail(concat("line ", line_, ": the data end before property ", printable(property.name),
                       " of ", name_row(element, row)));
  }

  static bool is_blank(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

  /// The next run of characters that are not blank; empty at the end of the file.
  std::string_view take_word() {
    while (at_ != end_ && is_blank(*at_)) {
      if (*at_ == line_end_) ++line_;
      ++at_;
    }
    const char* begin = at_;
    while (at_ != end_ && !is_blank(*at_)) ++at_;
    return {begin, static_cast<std::size_t>(at_ - begin)};
  }

  const char* at_;
  const char* end_;
  char line_end_;
  std::size_t line_;
};

/// Floats may stand for the bits of packed colours, and would change while they are converted.
PlyElement with_packed_colors_as_bits(PlyElement vertex, const PlyRoles& roles, PlyFormat format) {
  if (format == PlyFormat::ascii || roles[kColor] < 0 || roles[kColor + 1] >= 0) return vertex;
  PlyType& type = vertex.properties[static_cast<std::size_t>(roles[kColor])].type;
  if (type == PlyType::float32) type = PlyType::uint32;
  return vertex;
}

template <class Body>
Result<PointCloud> read_body(Body body, const PlyHeader& header, std::size_t data_size,
                             ReadNotes& notes) {
  std::optional<PointCloud> cloud;
  for (const PlyElement& declared : header.elements) {
    if (declared.name == "vertex") {
      const PlyRoles roles = TRY(assign_roles(declared));
      const PlyElement element = with_packed_colors_as_bits(declared, roles, header.format);
      // Plus one, because the last value of an ascii file needs no separator.
      const std::size_t rows = (data_size + 1) / min_row_size(element, header.format);
      PlyCloudBuilder builder(element, roles, header.format,
                              std::min<std::uint64_t>(element.count, rows));
      TRY(body.read(element, roles, builder));
      cloud = builder.finish(notes);
      notes.unread = unread_of(element, roles);
    } else if (const Result<void> skipped = body.skip(declared); !skipped) {
      if (!cloud) return tl::unexpected(skipped.error());
      // What follows the vertices is not used.
      notes.warnings.push_back(skipped.error().message + "; all vertices are read");
      break;
    }
  }
  if (!cloud) return fail("the header declares no element vertex");
  const PlyElement& last = header.elements.back();
  if (last.name == "vertex" && body.has_more(last)) {
    notes.warnings.push_back(
        concat("the header says ", last.count, " vertices, but more follow, which are not read"));
  }
  return std::move(*cloud);
}

}  // namespace

Result<PointCloud> read_ply(ByteView bytes, ReadNotes* told) {
  const PlyHeader header = TRY(parse_ply_header(bytes));
  ReadNotes ignored;
  ReadNotes& notes = told != nullptr ? *told : ignored;
  notes.warnings = header.warnings;
  const std::size_t data_size = bytes.size() - header.size;
  switch (header.format) {
    case PlyFormat::ascii:
      return read_body(AsciiBody(bytes, header), header, data_size, notes);
    case PlyFormat::little_endian:
      return read_body(BinaryBody<false>(bytes, header), header, data_size, notes);
    default:
      return read_body(BinaryBody<true>(bytes, header), header, data_size, notes);
  }
}

}  // namespace pointreel
