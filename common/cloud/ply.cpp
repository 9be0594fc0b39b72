#include "common/cloud/ply.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <initializer_list>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/concat.h"
#include "common/base/parse_number.h"
#include "common/base/reserve_large.h"
#include "common/base/try.h"
#include "common/cloud/ply_header.h"

namespace pointreel {
namespace {

/// Vertices pass through columns of doubles, a block of rows at a time, so that all formats and
/// types share the code that builds the cloud, and memory grows only with the rows that the data
/// hold.
constexpr std::size_t kBlockRows = 512;

/// The values that a vertex may have. A vector takes three consecutive numbers, and each scalar
/// field one.
enum Role : std::size_t {
  kPosition = 0,
  kNormal = 3,
  kColor = 6,
  kRadius = 9,
  kScalar = 10,
  kRoles = kScalar + kMaxScalars
};

using Column = std::array<double, kBlockRows>;
using Block = std::array<Column, kRoles>;

/// For each value, the index of the vertex's property that it is read from, or -1.
using RoleProperties = std::array<int, kRoles>;

int find_scalar(const PlyElement& element, const char* name) {
  const int at = element.find(name);
  return at >= 0 && !element.properties[static_cast<std::size_t>(at)].is_list ? at : -1;
}

/// Assigns the first of the `spellings` of which the element has all three properties.
void assign_vector(const PlyElement& element, Role role, RoleProperties& properties,
                   std::initializer_list<std::array<const char*, 3>> spellings) {
  for (const auto& names : spellings) {
    std::array<int, 3> at{};
    for (std::size_t i = 0; i < 3; ++i) at[i] = find_scalar(element, names[i]);
    if (std::min({at[0], at[1], at[2]}) < 0) continue;
    std::copy(at.begin(), at.end(), properties.begin() + role);
    return;
  }
}

bool is_taken(const RoleProperties& properties, std::size_t property) {
  return std::find(properties.begin(), properties.end(), static_cast<int>(property)) !=
         properties.end();
}

/// After all others.
void assign_scalars(const PlyElement& element, RoleProperties& properties) {
  std::size_t role = kScalar;
  for (std::size_t i = 0; i < element.properties.size() && role < kRoles; ++i) {
    const PlyProperty& property = element.properties[i];
    if (property.is_list || is_taken(properties, i) || !is_scalar_name(property.name)) continue;
    properties[role++] = static_cast<int>(i);
  }
}

Result<RoleProperties> assign_roles(const PlyElement& vertex) {
  RoleProperties properties;
  properties.fill(-1);
  for (const char* name : {"x", "y", "z"}) {
    if (find_scalar(vertex, name) >= 0) continue;
    return fail(concat("line ", vertex.line, ": element vertex has no scalar property ", name));
  }
  assign_vector(vertex, kPosition, properties, {{"x", "y", "z"}});
  assign_vector(vertex, kNormal, properties,
                {{"nx", "ny", "nz"}, {"normal_x", "normal_y", "normal_z"}});
  assign_vector(vertex, kColor, properties,
                {{"red", "green", "blue"},
                 {"r", "g", "b"},
                 {"diffuse_red", "diffuse_green", "diffuse_blue"}});
  properties[kRadius] = find_scalar(vertex, "radius");
  assign_scalars(vertex, properties);
  return properties;
}

/// The inverse: for each property, the value that it is read into, or kRoles if it is not read.
std::vector<Role> roles_by_property(const PlyElement& element, const RoleProperties* roles) {
  std::vector<Role> by_property(element.properties.size(), kRoles);
  for (std::size_t role = 0; roles != nullptr && role < kRoles; ++role) {
    if ((*roles)[role] < 0) continue;
    by_property[static_cast<std::size_t>((*roles)[role])] = static_cast<Role>(role);
  }
  return by_property;
}

bool is_float(PlyType type) { return type == PlyType::float32 || type == PlyType::float64; }

/// Some writers store colours from 0 to 255 as floats or 16-bit integers. Such floats are known by
/// the largest, which is in this range.
constexpr double kLargestShare = 2.0, kLargestByte = 255.5;

/// The values that stand for full brightness.
struct FullBrightness {
  double of_float = 1.0, of_uint16 = 65535.0;
};

/// Converts a colour component of the given type to the range 0 to 65535.
std::uint16_t color_value(PlyType type, double v, const FullBrightness& full) {
  if (!(v == v)) return 0;
  switch (type) {
    case PlyType::uint16:
      return static_cast<std::uint16_t>(std::clamp(v / full.of_uint16, 0.0, 1.0) * 65535.0 + 0.5);
    case PlyType::float32:
    case PlyType::float64:
      return static_cast<std::uint16_t>(std::clamp(v / full.of_float, 0.0, 1.0) * 65535.0 + 0.5);
    case PlyType::int8:
      if (v < 0.0) v += 256.0;
      [[fallthrough]];
    default:
      return static_cast<std::uint16_t>(257 * static_cast<int>(std::clamp(v, 0.0, 255.0)));
  }
}

/// Whether floats hold all numbers of a type.
bool fits_float(PlyType type) { return type == PlyType::float32 || size_of(type) <= 2; }

/// The least and the largest of the first `rows` numbers, with `low` and `high`.
void grow_range(const Column& column, std::size_t rows, double& low, double& high) {
  // Several at a time, of which compilers make vector instructions.
  std::array<double, 8> lows, highs;
  lows.fill(low);
  highs.fill(high);
  std::size_t at = 0;
  for (; at + 8 <= rows; at += 8) {
    for (std::size_t i = 0; i < 8; ++i) {
      lows[i] = std::min(lows[i], column[at + i]);
      highs[i] = std::max(highs[i], column[at + i]);
    }
  }
  for (; at < rows; ++at) {
    lows[0] = std::min(lows[0], column[at]);
    highs[0] = std::max(highs[0], column[at]);
  }
  low = *std::min_element(lows.begin(), lows.end());
  high = *std::max_element(highs.begin(), highs.end());
}

/// Whether floats can hold the first `rows` numbers: none is NaN, infinite, or would be as a float.
bool are_in_range(const Column& column, std::size_t rows) {
  bool in_range = true;
  for (std::size_t i = 0; i < rows; ++i)
    in_range &= std::abs(column[i]) <= static_cast<double>(std::numeric_limits<float>::max());
  return in_range;
}

/// Adds `rows` values, which `make` makes of their rows.
template <class T, class F>
void extend(std::vector<T>& values, std::size_t rows, F&& make) {
  const std::size_t begin = values.size();
  values.resize(begin + rows);
  for (std::size_t i = 0; i < rows; ++i) values[begin + i] = make(i);
}

/// Collects blocks of rows in a cloud. Most files have positions in floats and colours in bytes,
/// which become those of the cloud at once. Others wait for what all rows together tell: where the
/// origin is, and which value is full brightness.
class CloudBuilder {
 public:
  CloudBuilder(const PlyElement& vertex, const RoleProperties& properties, PlyFormat format,
               std::size_t max_rows)
      : has_normals_(properties[kNormal] >= 0),
        has_colors_(properties[kColor] >= 0),
        has_radii_(properties[kRadius] >= 0) {
    const auto type_of = [&](std::size_t role) {
      return vertex.properties[static_cast<std::size_t>(properties[role])].type;
    };
    // Numbers in ascii may have more digits than their types.
    float_positions_ = format != PlyFormat::ascii;
    for (std::size_t i = 0; i < 3; ++i) float_positions_ &= fits_float(type_of(kPosition + i));
    for (std::size_t i = 0; i < 3 && has_colors_; ++i) {
      color_types_[i] = type_of(kColor + i);
      byte_colors_ &= color_types_[i] == PlyType::uint8;
    }
    if (float_positions_) {
      reserve_large(cloud_.positions, max_rows);
    } else {
      reserve_large(positions_, max_rows);
    }
    if (has_normals_) reserve_large(cloud_.normals, max_rows);
    if (has_colors_ && byte_colors_) reserve_large(cloud_.colors, max_rows);
    if (has_colors_ && !byte_colors_) reserve_large(colors_, max_rows);
    if (has_radii_) reserve_large(cloud_.radii, max_rows);
    for (std::size_t role = kScalar; role < kRoles && properties[role] >= 0; ++role) {
      const auto property = static_cast<std::size_t>(properties[role]);
      cloud_.scalars.push_back({vertex.properties[property].name, {}});
      reserve_large(cloud_.scalars.back().values, max_rows);
    }
  }

  void append(const Block& block, std::size_t rows) {
    grow_box(block, rows);
    const auto vector_at = [&block](Role role, std::size_t i) {
      return glm::dvec3(block[role][i], block[role + 1][i], block[role + 2][i]);
    };
    if (float_positions_) {
      extend(cloud_.positions, rows,
             [&](std::size_t i) { return glm::vec3(vector_at(kPosition, i)); });
    } else {
      extend(positions_, rows, [&](std::size_t i) { return vector_at(kPosition, i); });
    }
    if (has_normals_)
      extend(cloud_.normals, rows, [&](std::size_t i) { return glm::vec3(vector_at(kNormal, i)); });
    if (has_colors_ && byte_colors_) {
      extend(cloud_.colors, rows,
             [&](std::size_t i) { return glm::u16vec3(glm::ivec3(vector_at(kColor, i)) * 257); });
    } else if (has_colors_) {
      extend(colors_, rows, [&](std::size_t i) { return glm::vec3(vector_at(kColor, i)); });
    }
    if (has_radii_)
      extend(cloud_.radii, rows,
             [&](std::size_t i) { return static_cast<float>(block[kRadius][i]); });
    for (std::size_t field = 0; field < cloud_.scalars.size(); ++field) {
      const Column& column = block[kScalar + field];
      extend(cloud_.scalars[field].values, rows,
             [&](std::size_t i) { return static_cast<float>(column[i]); });
    }
  }

  PointCloud finish() {
    if (has_colors_ && !byte_colors_) convert_colors();
    cloud_.origin = choose_origin();
    if (!float_positions_) {
      extend(cloud_.positions, positions_.size(),
             [&](std::size_t i) { return glm::vec3(positions_[i] - cloud_.origin); });
    } else if (cloud_.origin != glm::dvec3(0.0)) {
      for (glm::vec3& p : cloud_.positions) p = glm::vec3(glm::dvec3(p) - cloud_.origin);
    }
    return std::move(cloud_);
  }

 private:
  /// Only by points that floats can hold.
  void grow_box(const Block& block, std::size_t rows) {
    bool in_range = true;
    for (std::size_t axis = 0; axis < 3; ++axis)
      in_range &= are_in_range(block[kPosition + axis], rows);
    if (in_range) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto i = static_cast<glm::length_t>(axis);
        grow_range(block[kPosition + axis], rows, box_.min[i], box_.max[i]);
      }
      return;
    }
    constexpr double kLargest = std::numeric_limits<float>::max();
    for (std::size_t i = 0; i < rows; ++i) {
      const glm::dvec3 p(block[kPosition][i], block[kPosition + 1][i], block[kPosition + 2][i]);
      const glm::dvec3 size = glm::abs(p);  // comparisons are false for NaN
      if (size.x <= kLargest && size.y <= kLargest && size.z <= kLargest) box_.grow(p);
    }
  }

  double largest_color(bool (*of_type)(PlyType)) const {
    double largest = 0.0;
    for (const glm::vec3& color : colors_) {
      for (int channel = 0; channel < 3; ++channel) {
        if (of_type(color_types_[static_cast<std::size_t>(channel)]) && color[channel] > largest)
          largest = color[channel];
      }
    }
    return largest;
  }

  void convert_colors() {
    FullBrightness full;
    const double largest_float = largest_color(is_float);
    if (largest_float > kLargestShare && largest_float < kLargestByte) full.of_float = 255.0;
    // Nobody stores 16 bits to keep colours that are all but black.
    if (largest_color([](PlyType type) { return type == PlyType::uint16; }) <= 255.0)
      full.of_uint16 = 255.0;
    extend(cloud_.colors, colors_.size(), [&](std::size_t i) {
      glm::u16vec3 color;
      for (int channel = 0; channel < 3; ++channel)
        color[channel] =
            color_value(color_types_[static_cast<std::size_t>(channel)], colors_[i][channel], full);
      return color;
    });
  }

  glm::dvec3 choose_origin() const {
    if (box_.empty()) return glm::dvec3(0.0);
    const glm::dvec3 reach = glm::max(glm::abs(box_.min), glm::abs(box_.max));
    const glm::dvec3 extent = box_.extent();
    const double largest = std::max({reach.x, reach.y, reach.z});
    const double longest = std::max({extent.x, extent.y, extent.z});
    return largest > 2.0 * longest ? box_.min : glm::dvec3(0.0);
  }

  PointCloud cloud_;
  std::vector<glm::dvec3> positions_;  ///< unless floats hold them
  std::vector<glm::vec3> colors_;      ///< as they are in the file, unless they are bytes
  Box box_;
  std::array<PlyType, 3> color_types_{};
  bool has_normals_, has_colors_, has_radii_;
  bool float_positions_ = false, byte_colors_ = true;
};

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

  Result<void> read(const PlyElement& vertex, const RoleProperties& roles, CloudBuilder& builder) {
    if (has_lists(vertex)) return walk(vertex, &roles, &builder);
    const std::size_t row_size = min_row_size(vertex, PlyFormat::little_endian);
    const std::uint8_t* const rows = TRY(take_rows(vertex, row_size));
    Block block;
    for (std::uint64_t row = 0; row < vertex.count; row += kBlockRows) {
      const std::size_t n = std::min<std::uint64_t>(kBlockRows, vertex.count - row);
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
  Result<void> walk(const PlyElement& element, const RoleProperties* roles, CloudBuilder* builder) {
    const std::vector<Role> role_of = roles_by_property(element, roles);
    Block block;
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
      if (builder != nullptr && (++filled == kBlockRows || row + 1 == element.count)) {
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
        line_(header.lines + 1) {}

  Result<void> skip(const PlyElement& element) { return walk(element, nullptr, nullptr); }

  Result<void> read(const PlyElement& vertex, const RoleProperties& roles, CloudBuilder& builder) {
    return walk(vertex, &roles, &builder);
  }

 private:
  Result<void> walk(const PlyElement& element, const RoleProperties* roles, CloudBuilder* builder) {
    if (element.properties.empty()) return {};
    const std::vector<Role> role_of = roles_by_property(element, roles);
    Block block;
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
      if (builder != nullptr && (++filled == kBlockRows || row + 1 == element.count)) {
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
      if (*at_ == '\n') ++line_;
      ++at_;
    }
    const char* begin = at_;
    while (at_ != end_ && !is_blank(*at_)) ++at_;
    return {begin, static_cast<std::size_t>(at_ - begin)};
  }

  const char* at_;
  const char* end_;
  std::size_t line_;
};

std::vector<std::string> names_of_unread(const PlyElement& vertex, const RoleProperties& roles) {
  const std::vector<Role> by_property = roles_by_property(vertex, &roles);
  std::vector<std::string> names;
  for (std::size_t i = 0; i < by_property.size(); ++i) {
    const PlyProperty& property = vertex.properties[i];
    if (by_property[i] == kRoles && !property.is_list) names.push_back(printable(property.name));
  }
  return names;
}

template <class Body>
Result<PointCloud> read_body(Body body, const PlyHeader& header, std::size_t data_size,
                             std::vector<std::string>* unread) {
  Result<PointCloud> cloud = fail("the header declares no element vertex");
  for (const PlyElement& element : header.elements) {
    if (element.name == "vertex") {
      const RoleProperties roles = TRY(assign_roles(element));
      // Plus one, because the last value of an ascii file needs no separator.
      const std::size_t rows = (data_size + 1) / min_row_size(element, header.format);
      CloudBuilder builder(element, roles, header.format,
                           std::min<std::uint64_t>(element.count, rows));
      TRY(body.read(element, roles, builder));
      cloud = builder.finish();
      if (unread != nullptr) *unread = names_of_unread(element, roles);
    } else {
      TRY(body.skip(element));
    }
  }
  return cloud;
}

}  // namespace

Result<PointCloud> read_ply(ByteView bytes, std::vector<std::string>* unread) {
  const PlyHeader header = TRY(parse_ply_header(bytes));
  const std::size_t data_size = bytes.size() - header.size;
  switch (header.format) {
    case PlyFormat::ascii:
      return read_body(AsciiBody(bytes, header), header, data_size, unread);
    case PlyFormat::little_endian:
      return read_body(BinaryBody<false>(bytes, header), header, data_size, unread);
    default:
      return read_body(BinaryBody<true>(bytes, header), header, data_size, unread);
  }
}

}  // namespace pointreel
