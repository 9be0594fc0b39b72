#include "common/cloud/ply_cloud_builder.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <utility>

#include "common/base/concat.h"
#include "common/base/reserve_large.h"

namespace pointreel {
namespace {

int find_scalar(const PlyElement& element, const char* name) {
  const int at = element.find(name);
  return at >= 0 && !element.properties[static_cast<std::size_t>(at)].is_list ? at : -1;
}

/// Assigns the first of the `spellings` of which the element has all three properties.
void assign_vector(const PlyElement& element, PlyRole role, PlyRoles& properties,
                   std::initializer_list<std::array<const char*, 3>> spellings) {
  for (const auto& names : spellings) {
    std::array<int, 3> at{};
    for (std::size_t i = 0; i < 3; ++i) at[i] = find_scalar(element, names[i]);
    if (std::min({at[0], at[1], at[2]}) < 0) continue;
    std::copy(at.begin(), at.end(), properties.begin() + role);
    return;
  }
}

bool is_taken(const PlyRoles& properties, std::size_t property) {
  return std::find(properties.begin(), properties.end(), static_cast<int>(property)) !=
         properties.end();
}

/// After all others.
void assign_scalars(const PlyElement& element, PlyRoles& properties) {
  std::size_t role = kScalar;
  for (std::size_t i = 0; i < element.properties.size() && role < kRoles; ++i) {
    const PlyProperty& property = element.properties[i];
    if (property.is_list || is_taken(properties, i) || !is_scalar_name(property.name)) continue;
    properties[role++] = static_cast<int>(i);
  }
}

bool is_float(PlyType type) { return type == PlyType::float32 || type == PlyType::float64; }

/// Some writers store colours from 0 to 255 as floats or 16-bit integers. Such floats are known by
/// the largest, which is in this range.
constexpr double kLargestShare = 2.0, kLargestByte = 255.5;

/// The values that stand for full brightness.
struct FullBrightness {
  double of_float = 1.0, of_uint16 = 65535.0;
};

/// Converts a colour component of eight bits to the range 0 to 65535. Ascii files may hold any
/// number: it is clamped, and NaN becomes 0.
std::uint16_t byte_color(double v) {
  return static_cast<std::uint16_t>(257 * static_cast<int>(std::min(std::max(0.0, v), 255.0)));
}

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
      return byte_color(v);
  }
}

/// Whether floats hold all numbers of a type.
bool fits_float(PlyType type) { return type == PlyType::float32 || size_of(type) <= 2; }

/// The least and the largest of the first `rows` numbers, with `low` and `high`.
void grow_range(const PlyColumn& column, std::size_t rows, double& low, double& high) {
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
bool are_in_range(const PlyColumn& column, std::size_t rows) {
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

}  // namespace

Result<PlyRoles> assign_roles(const PlyElement& vertex) {
  PlyRoles properties;
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

std::vector<PlyRole> roles_by_property(const PlyElement& element, const PlyRoles* roles) {
  std::vector<PlyRole> by_property(element.properties.size(), kRoles);
  for (std::size_t role = 0; roles != nullptr && role < kRoles; ++role) {
    if ((*roles)[role] < 0) continue;
    by_property[static_cast<std::size_t>((*roles)[role])] = static_cast<PlyRole>(role);
  }
  return by_property;
}

PlyCloudBuilder::PlyCloudBuilder(const PlyElement& vertex, const PlyRoles& properties,
                                 PlyFormat format, std::size_t max_rows)
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

void PlyCloudBuilder::append(const PlyBlock& block, std::size_t rows) {
  grow_box(block, rows);
  const auto vector_at = [&block](PlyRole role, std::size_t i) {
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
    extend(cloud_.colors, rows, [&](std::size_t i) {
      return glm::u16vec3(byte_color(block[kColor][i]), byte_color(block[kColor + 1][i]),
                          byte_color(block[kColor + 2][i]));
    });
  } else if (has_colors_) {
    extend(colors_, rows, [&](std::size_t i) { return glm::vec3(vector_at(kColor, i)); });
  }
  if (has_radii_)
    extend(cloud_.radii, rows,
           [&](std::size_t i) { return static_cast<float>(block[kRadius][i]); });
  for (std::size_t field = 0; field < cloud_.scalars.size(); ++field) {
    const PlyColumn& column = block[kScalar + field];
    extend(cloud_.scalars[field].values, rows,
           [&](std::size_t i) { return static_cast<float>(column[i]); });
  }
}

PointCloud PlyCloudBuilder::finish() {
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

/// Only by points that floats can hold.
void PlyCloudBuilder::grow_box(const PlyBlock& block, std::size_t rows) {
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

double PlyCloudBuilder::largest_color(bool (*of_type)(PlyType)) const {
  double largest = 0.0;
  for (const glm::vec3& color : colors_) {
    for (int channel = 0; channel < 3; ++channel) {
      if (of_type(color_types_[static_cast<std::size_t>(channel)]) && color[channel] > largest)
        largest = color[channel];
    }
  }
  return largest;
}

void PlyCloudBuilder::convert_colors() {
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

glm::dvec3 PlyCloudBuilder::choose_origin() const {
  if (box_.empty()) return glm::dvec3(0.0);
  const glm::dvec3 reach = glm::max(glm::abs(box_.min), glm::abs(box_.max));
  const glm::dvec3 extent = box_.extent();
  const double largest = std::max({reach.x, reach.y, reach.z});
  const double longest = std::max({extent.x, extent.y, extent.z});
  return largest > 2.0 * longest ? box_.min : glm::dvec3(0.0);
}

}  // namespace pointreel
