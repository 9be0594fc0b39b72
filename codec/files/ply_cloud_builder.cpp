#include "codec/files/ply_cloud_builder.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>

#include "codec/files/attribute_names.h"
#include "codec/files/full_color.h"
#include "codec/files/middle_half.h"
#include "common/base/concat.h"
#include "common/base/letter_case.h"
#include "common/base/reserve_large.h"
#include "common/base/spread.h"

namespace pointreel {
namespace {

/// The mean colour of Gaussian splats, as coefficients of a constant function on the sphere.
constexpr VectorNames kHarmonicNames{"f_dc_0", "f_dc_1", "f_dc_2"};
constexpr float kHarmonic = 0.28209479f;  // 1 / (2 sqrt(pi))

int find_scalar(const PlyElement& element, std::string_view name) {
  const int at = element.find_any_case(name);
  return at >= 0 && !element.properties[static_cast<std::size_t>(at)].is_list ? at : -1;
}

/// Assigns the first of the `spellings` of which the element has all three properties. Whether
/// there is one.
bool assign_vector(const PlyElement& element, PlyRole role, PlyRoles& properties,
                   std::span<const VectorNames> spellings) {
  for (const VectorNames& names : spellings) {
    std::array<int, 3> at{};
    for (std::size_t i = 0; i < 3; ++i) at[i] = find_scalar(element, names[i]);
    if (std::min({at[0], at[1], at[2]}) < 0) continue;
    std::copy(at.begin(), at.end(), properties.begin() + role);
    return true;
  }
  return false;
}

bool is_float(PlyType type) { return type == PlyType::float32 || type == PlyType::float64; }

void assign_color(const PlyElement& element, PlyRoles& properties) {
  if (assign_vector(element, kColor, properties, kColorNames)) return;
  for (const std::string_view name : kPackedColorNames) {
    const int at = find_scalar(element, name);
    if (at < 0 || size_of(element.properties[static_cast<std::size_t>(at)].type) != 4) continue;
    properties[kColor] = at;
    return;
  }
  if (is_splat(element)) assign_vector(element, kColor, properties, {&kHarmonicNames, 1});
}

/// What a splat has besides its place and its mean colour means nothing for a point.
bool is_splat_shape(std::string_view name) {
  const std::string small = in_small_letters(name);
  return small.starts_with("f_dc_") || small.starts_with("f_rest_") ||
         small.starts_with("scale_") || small.starts_with("rot_") || small == "opacity";
}

bool is_taken(const PlyRoles& properties, std::size_t property) {
  return std::find(properties.begin(), properties.end(), static_cast<int>(property)) !=
         properties.end();
}

/// After all others.
void assign_scalars(const PlyElement& element, PlyRoles& properties) {
  std::size_t role = kScalar;
  const bool splat = is_splat(element);
  for (std::size_t i = 0; i < element.properties.size() && role < kRoles; ++i) {
    const PlyProperty& property = element.properties[i];
    if (property.is_list || is_taken(properties, i) || !is_scalar_name(property.name)) continue;
    if (splat && is_splat_shape(property.name)) continue;
    properties[role++] = static_cast<int>(i);
  }
}

bool is_byte(PlyType type) { return size_of(type) == 1; }

/// Converts a colour component of eight bits to the range 0 to 65535. Ascii files may hold any
/// number: it is clamped, and NaN becomes 0.
std::uint16_t byte_color(double v) {
  return static_cast<std::uint16_t>(257 * static_cast<int>(std::min(std::max(0.0, v), 255.0)));
}

/// Converts a colour component of the given type to the range 0 to 65535. `full`: full_color.h
std::uint16_t color_value(PlyType type, double v, double full) {
  if (!is_byte(type)) return color_of(v, full);
  return byte_color(type == PlyType::int8 && v < 0.0 ? v + 256.0 : v);
}

/// Packed colours are whole numbers, or in ascii also the floats of the same bits.
glm::u16vec3 unpacked_color(PlyType type, double v) {
  const bool is_bits = is_float(type) && !(v >= 1.0 && v == std::floor(v));
  const bool fits = std::abs(v) <= std::numeric_limits<std::uint32_t>::max();
  const auto packed = is_bits ? std::bit_cast<std::uint32_t>(static_cast<float>(v))
                      : fits  ? static_cast<std::uint32_t>(static_cast<std::int64_t>(v))
                              : 0u;
  return {257 * (packed >> 16 & 255), 257 * (packed >> 8 & 255), 257 * (packed & 255)};
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

/// MiddleHalf::origin of the points that were measured, if these lie far from zero: those at zero,
/// which were not, must not cost them their precision.
glm::dvec3 far_middle(std::span<const glm::dvec3> positions) {
  constexpr std::size_t kSamples = 1024;
  constexpr double kFarSpreads = 100.0;
  const std::size_t count = std::min(kSamples, positions.size());
  std::array<std::vector<double>, 3> values;
  for (std::size_t i = 0; i < count; ++i) {
    const glm::dvec3& position = positions[spread_index(i, count, positions.size())];
    if (position == glm::dvec3(0.0)) continue;
    for (int axis = 0; axis < 3; ++axis)
      if (std::abs(position[axis]) <= static_cast<double>(std::numeric_limits<float>::max()))
        values[static_cast<std::size_t>(axis)].push_back(position[axis]);
  }
  if (std::ranges::any_of(values, &std::vector<double>::empty)) return glm::dvec3(0.0);
  const MiddleHalf half = middle_half(values);
  return half.spread > 0.0 && half.is_far(kFarSpreads) ? half.origin() : glm::dvec3(0.0);
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
  if (!assign_vector(vertex, kPosition, properties, kPositionNames)) {
    if (vertex.find("packed_position") >= 0) {
      return fail(concat("line ", vertex.line,
                         ": has compressed Gaussian splats, which are not read: save them as PLY "
                         "without compression"));
    }
    for (const std::string_view name : kPositionNames.front()) {
      if (find_scalar(vertex, name) >= 0) continue;
      return fail(concat("line ", vertex.line, ": element vertex has no scalar property ", name));
    }
  }
  assign_vector(vertex, kNormal, properties, kNormalNames);
  assign_color(vertex, properties);
  properties[kRadius] = find_scalar(vertex, "radius");
  assign_scalars(vertex, properties);
  return properties;
}

bool is_splat(const PlyElement& vertex) {
  return std::all_of(kHarmonicNames.begin(), kHarmonicNames.end(), [&](std::string_view name) {
    const int at = find_scalar(vertex, name);
    return at >= 0 && is_float(vertex.properties[static_cast<std::size_t>(at)].type);
  });
}

std::vector<std::string> unread_of(const PlyElement& vertex, const PlyRoles& roles) {
  const std::vector<PlyRole> by_property = roles_by_property(vertex, &roles);
  const bool splat = is_splat(vertex);
  std::vector<std::string> names;
  for (std::size_t i = 0; i < by_property.size(); ++i) {
    const PlyProperty& property = vertex.properties[i];
    if (by_property[i] != kRoles || property.is_list) continue;
    std::string name = printable(property.name);
    if (splat && is_splat_shape(name) && name.find('_') != std::string::npos)
      name.replace(name.rfind('_') + 1, std::string::npos, "*");
    if (names.empty() || names.back() != name) names.push_back(std::move(name));
  }
  return names;
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
      has_radii_(properties[kRadius] >= 0),
      packed_colors_(has_colors_ && properties[kColor + 1] < 0) {
  const auto type_of = [&](std::size_t role) {
    return vertex.properties[static_cast<std::size_t>(properties[role])].type;
  };
  // Numbers in ascii may have more digits than their types.
  float_positions_ = format != PlyFormat::ascii;
  for (std::size_t i = 0; i < 3; ++i) float_positions_ &= fits_float(type_of(kPosition + i));
  if (packed_colors_) color_types_[0] = type_of(kColor);
  for (std::size_t i = 0; i < 3 && has_colors_ && !packed_colors_; ++i) {
    color_types_[i] = type_of(kColor + i);
    byte_colors_ &= color_types_[i] == PlyType::uint8;
  }
  harmonic_colors_ =
      has_colors_ &&
      equal_in_any_case(vertex.properties[static_cast<std::size_t>(properties[kColor])].name,
                        kHarmonicNames[0]);
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
    losses_.emplace_back(fits_float(vertex.properties[property].type));
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
  if (packed_colors_) {
    extend(cloud_.colors, rows,
           [&](std::size_t i) { return unpacked_color(color_types_[0], block[kColor][i]); });
  } else if (has_colors_ && byte_colors_) {
    extend(cloud_.colors, rows, [&](std::size_t i) {
      return glm::u16vec3(byte_color(block[kColor][i]), byte_color(block[kColor + 1][i]),
                          byte_color(block[kColor + 2][i]));
    });
  } else if (has_colors_) {
    extend(colors_, rows, [&](std::size_t i) {
      const glm::vec3 color(vector_at(kColor, i));
      return harmonic_colors_ ? glm::clamp(0.5f + kHarmonic * color, 0.0f, 1.0f) : color;
    });
  }
  if (has_radii_)
    extend(cloud_.radii, rows,
           [&](std::size_t i) { return static_cast<float>(block[kRadius][i]); });
  for (std::size_t field = 0; field < cloud_.scalars.size(); ++field) {
    const PlyColumn& column = block[kScalar + field];
    for (std::size_t i = 0; i < rows; ++i) losses_[field].see(column[i]);
    extend(cloud_.scalars[field].values, rows,
           [&](std::size_t i) { return static_cast<float>(column[i]); });
  }
}

PointCloud PlyCloudBuilder::finish(ReadNotes& notes) {
  if (has_colors_ && !byte_colors_) convert_colors(notes);
  cloud_.origin = choose_origin();
  if (!float_positions_) {
    extend(cloud_.positions, positions_.size(),
           [&](std::size_t i) { return glm::vec3(positions_[i] - cloud_.origin); });
  } else if (cloud_.origin != glm::dvec3(0.0)) {
    for (glm::vec3& p : cloud_.positions) p = glm::vec3(glm::dvec3(p) - cloud_.origin);
  }
  for (std::size_t i = 0; i < losses_.size(); ++i)
    if (const auto line = losses_[i].warning(cloud_.scalars[i].name))
      notes.warnings.push_back(*line);
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

void PlyCloudBuilder::convert_colors(ReadNotes& notes) {
  double full = 1.0, largest = 0.0;
  bool floats = false, wide = false;
  for (std::size_t channel = 0; channel < 3; ++channel) {
    if (is_byte(color_types_[channel])) continue;
    floats |= is_float(color_types_[channel]);
    wide = true;
    for (const glm::vec3& color : colors_) {
      const float value = color[static_cast<glm::length_t>(channel)];
      if (value > largest) largest = value;
    }
  }
  if (wide && !harmonic_colors_) full = choose_full_color(largest, floats, notes);
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
  if (largest > 2.0 * longest) return box_.min;
  return far_middle(positions_);
}

}  // namespace pointreel
