#include "codec/files/records.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "codec/core/finite.h"
#include "codec/files/full_color.h"
#include "codec/files/middle_half.h"
#include "common/base/concat.h"
#include "common/base/reserve_large.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

/// Rows are converted in blocks that stay in the processor's first cache.
constexpr std::size_t kBlockRows = 512;
/// What is read from a disk at a time stays in the second.
constexpr std::size_t kBlockBytes = std::size_t{256} << 10;
/// About as many measured rows have the origin in their middle.
constexpr std::size_t kOriginRows = 1024;
/// Points whose middle is further from zero than so many times the middle half of them is long.
constexpr double kFarSpreads = 4.0;

using Block = std::array<double, kBlockRows>;

/// Reads a column of numbers.
template <class Out>
void load_column(const RecordField& field, bool swapped, const std::uint8_t* base,
                 std::size_t first, std::size_t rows, Out* out) {
  const std::uint8_t* const from = base + field.offset + first * field.stride;
  const std::size_t stride = field.stride;
  with_number_type(field.type, [=](auto type) {
    using T = decltype(type);
    if (swapped) {
      for (std::size_t i = 0; i < rows; ++i)
        out[i] = static_cast<Out>(load_number<T, true>(from + i * stride));
    } else {
      for (std::size_t i = 0; i < rows; ++i)
        out[i] = static_cast<Out>(load_number<T>(from + i * stride));
    }
  });
}

/// Whether three numbers follow each other in the byte order of this machine.
bool adjacent(const RecordVector& fields, NumberType type, bool swapped) {
  const std::size_t size = size_of(type);
  return !swapped && fields[0].type == type && fields[1].type == type && fields[2].type == type &&
         fields[1].offset == fields[0].offset + size &&
         fields[2].offset == fields[1].offset + size && fields[1].stride == fields[0].stride &&
         fields[2].stride == fields[0].stride;
}

bool holds_all(NumberType type) { return type == NumberType::float32 || size_of(type) <= 2; }

template <class T>
std::array<T, 3> load_three(const std::uint8_t* at) {
  std::array<T, 3> values;
  std::memcpy(values.data(), at, sizeof(values));
  return values;
}

bool is_wide(NumberType type) { return size_of(type) > 1 && !is_float(type); }

}  // namespace

RecordCollector::RecordCollector(const RecordLayout& layout, std::size_t rows)
    : layout_(layout),
      positions_(holds_all(layout.position[0].type) && holds_all(layout.position[1].type) &&
                         holds_all(layout.position[2].type) && layout.scale == glm::dvec3(1.0) &&
                         layout.offset == glm::dvec3(0.0)
                     ? Positions::floats
                     : Positions::scaled) {
  reserve_large(cloud_.positions, rows);
  if (layout_.normal) reserve_large(cloud_.normals, rows);
  for (const RecordScalar& scalar : layout_.scalars) {
    cloud_.scalars.push_back({scalar.name, {}});
    losses_.emplace_back(holds_all(scalar.field.type));
    reserve_large(cloud_.scalars.back().values, rows);
  }
  const bool float_colors = layout_.color && is_float((*layout_.color)[0].type);
  if (float_colors) reserve_large(float_colors_, rows);
  if ((layout_.color && !float_colors) || layout_.packed_color) reserve_large(cloud_.colors, rows);
}

void RecordCollector::add(const std::uint8_t* base, std::size_t first, std::size_t rows) {
  if (positions_ == Positions::scaled && !has_origin_) choose_origin(base, first, rows);
  for (std::size_t at = 0; at < rows; at += kBlockRows) {
    const std::size_t n = std::min(kBlockRows, rows - at);
    add_positions(base, first + at, n);
    if (layout_.normal) add_normals(base, first + at, n);
    if (layout_.color || layout_.packed_color) add_colors(base, first + at, n);
    add_scalars(base, first + at, n);
  }
}

void RecordCollector::choose_origin(const std::uint8_t* base, std::size_t first, std::size_t rows) {
  std::array<std::vector<double>, 3> measured;  // by axis
  for (std::size_t at = 0; at < rows && measured[0].size() < kOriginRows; at += kBlockRows) {
    const std::size_t n = std::min(kBlockRows, rows - at);
    std::array<Block, 3> columns;
    for (std::size_t axis = 0; axis < 3; ++axis)
      load_column(layout_.position[axis], layout_.swapped, base, first + at, n,
                  columns[axis].data());
    for (std::size_t i = 0; i < n; ++i) {
      const glm::dvec3 world =
          layout_.scale * glm::dvec3(columns[0][i], columns[1][i], columns[2][i]) + layout_.offset;
      // Scanners write 0 0 0 where they met nothing.
      if (world == glm::dvec3(0.0) || !std::isfinite(world.x + world.y + world.z)) continue;
      for (int axis = 0; axis < 3; ++axis)
        measured[static_cast<std::size_t>(axis)].push_back(world[axis]);
    }
  }
  if (measured[0].empty()) return;  // the next rows may have some
  const MiddleHalf half = middle_half(measured);
  has_origin_ = true;
  if (!half.is_far(kFarSpreads)) return;  // points around zero need no other origin
  cloud_.origin = half.origin();
  for (glm::vec3& position : cloud_.positions)  // none of which was measured
    position = glm::vec3(glm::dvec3(position) - cloud_.origin);
}

void RecordCollector::add_positions(const std::uint8_t* base, std::size_t first, std::size_t rows) {
  std::array<glm::vec3, kBlockRows> block;
  const RecordVector& fields = layout_.position;
  const std::uint8_t* const from = base + fields[0].offset + first * fields[0].stride;
  const std::size_t stride = fields[0].stride;
  if (positions_ == Positions::floats && adjacent(fields, NumberType::float32, layout_.swapped)) {
    for (std::size_t i = 0; i < rows; ++i) {
      const auto p = load_three<float>(from + i * stride);
      block[i] = glm::vec3(p[0], p[1], p[2]);
    }
  } else if (positions_ == Positions::floats) {
    std::array<float, kBlockRows> column;
    for (int axis = 0; axis < 3; ++axis) {
      load_column(fields[static_cast<std::size_t>(axis)], layout_.swapped, base, first, rows,
                  column.data());
      for (std::size_t i = 0; i < rows; ++i) block[i][axis] = column[i];
    }
  } else if (adjacent(fields, NumberType::int32, layout_.swapped)) {
    const glm::dvec3 scale = layout_.scale, shift = layout_.offset - cloud_.origin;
    for (std::size_t i = 0; i < rows; ++i) {
      const auto p = load_three<std::int32_t>(from + i * stride);
      block[i] = glm::vec3(static_cast<float>(scale.x * p[0] + shift.x),
                           static_cast<float>(scale.y * p[1] + shift.y),
                           static_cast<float>(scale.z * p[2] + shift.z));
    }
  } else {
    Block column;
    for (int axis = 0; axis < 3; ++axis) {
      load_column(fields[static_cast<std::size_t>(axis)], layout_.swapped, base, first, rows,
                  column.data());
      const double scale = layout_.scale[axis], shift = layout_.offset[axis] - cloud_.origin[axis];
      for (std::size_t i = 0; i < rows; ++i)
        block[i][axis] = static_cast<float>(scale * column[i] + shift);
    }
  }
  if (positions_ == Positions::floats) grow_bounds({block.data(), rows});
  cloud_.positions.insert(cloud_.positions.end(), block.begin(),
                          block.begin() + static_cast<std::ptrdiff_t>(rows));
}

/// The bounds of finite positions, while they are in the cache.
void RecordCollector::grow_bounds(std::span<const glm::vec3> positions) {
  std::size_t at = 0;
  if (are_finite(positions)) {
    // Four points at a time, of which compilers make vector instructions.
    std::array<float, 12> low, high;
    for (std::size_t i = 0; i < 12; ++i) {
      low[i] = low_[static_cast<int>(i % 3)];
      high[i] = high_[static_cast<int>(i % 3)];
    }
    for (; at + 4 <= positions.size(); at += 4) {
      std::array<float, 12> four;
      std::memcpy(four.data(), &positions[at], sizeof(four));
      for (std::size_t i = 0; i < 12; ++i) {
        low[i] = std::min(low[i], four[i]);
        high[i] = std::max(high[i], four[i]);
      }
    }
    for (std::size_t i = 0; i < 12; ++i) {
      low_[static_cast<int>(i % 3)] = std::min(low_[static_cast<int>(i % 3)], low[i]);
      high_[static_cast<int>(i % 3)] = std::max(high_[static_cast<int>(i % 3)], high[i]);
    }
  }
  for (const glm::vec3& p : positions.subspan(at)) {
    if (!are_finite({&p, 1})) continue;
    low_ = glm::min(low_, p);
    high_ = glm::max(high_, p);
  }
}

void RecordCollector::add_normals(const std::uint8_t* base, std::size_t first, std::size_t rows) {
  std::array<glm::vec3, kBlockRows> block;
  std::array<float, kBlockRows> column;
  for (int axis = 0; axis < 3; ++axis) {
    load_column((*layout_.normal)[static_cast<std::size_t>(axis)], layout_.swapped, base, first,
                rows, column.data());
    for (std::size_t i = 0; i < rows; ++i) block[i][axis] = column[i];
  }
  cloud_.normals.insert(cloud_.normals.end(), block.begin(),
                        block.begin() + static_cast<std::ptrdiff_t>(rows));
}

void RecordCollector::add_colors(const std::uint8_t* base, std::size_t first, std::size_t rows) {
  std::array<glm::u16vec3, kBlockRows> block;
  if (!layout_.color) {
    const RecordField& field = *layout_.packed_color;
    std::array<std::uint32_t, kBlockRows> packed;
    RecordField bits = field;
    if (field.type == NumberType::float32) bits.type = NumberType::uint32;
    load_column(bits, layout_.swapped, base, first, rows, packed.data());
    for (std::size_t i = 0; i < rows; ++i) {
      const std::uint32_t v = packed[i];
      block[i] = glm::u16vec3(257 * ((v >> 16) & 255), 257 * ((v >> 8) & 255), 257 * (v & 255));
    }
  } else if (is_float((*layout_.color)[0].type)) {
    std::array<glm::vec3, kBlockRows> colors;
    std::array<float, kBlockRows> column;
    for (int channel = 0; channel < 3; ++channel) {
      load_column((*layout_.color)[static_cast<std::size_t>(channel)], layout_.swapped, base, first,
                  rows, column.data());
      for (std::size_t i = 0; i < rows; ++i) colors[i][channel] = column[i];
    }
    float_colors_.insert(float_colors_.end(), colors.begin(),
                         colors.begin() + static_cast<std::ptrdiff_t>(rows));
    return;
  } else if (adjacent(*layout_.color, NumberType::uint16, layout_.swapped)) {
    const RecordField& field = (*layout_.color)[0];
    const std::uint8_t* const from = base + field.offset + first * field.stride;
    std::uint16_t brightest = brightest_;
    for (std::size_t i = 0; i < rows; ++i) {
      const auto c = load_three<std::uint16_t>(from + i * field.stride);
      block[i] = glm::u16vec3(c[0], c[1], c[2]);
      brightest = std::max({brightest, c[0], c[1], c[2]});
    }
    brightest_ = brightest;
  } else {
    Block column;
    for (int channel = 0; channel < 3; ++channel) {
      const RecordField& field = (*layout_.color)[static_cast<std::size_t>(channel)];
      load_column(field, layout_.swapped, base, first, rows, column.data());
      const bool is_signed_byte = field.type == NumberType::int8;
      const bool wide = is_wide(field.type);
      for (std::size_t i = 0; i < rows; ++i) {
        double v = column[i];
        if (is_signed_byte && v < 0.0) v += 256.0;  // the same bits
        const auto c = static_cast<std::uint16_t>(v > 0.0 ? std::min(v, 65535.0) : 0.0);
        block[i][channel] = wide ? c : static_cast<std::uint16_t>(257 * c);
        if (wide) brightest_ = std::max(brightest_, c);
      }
    }
  }
  cloud_.colors.insert(cloud_.colors.end(), block.begin(),
                       block.begin() + static_cast<std::ptrdiff_t>(rows));
}

void RecordCollector::add_scalars(const std::uint8_t* base, std::size_t first, std::size_t rows) {
  std::array<float, kBlockRows> column;
  Block wide;
  for (std::size_t i = 0; i < layout_.scalars.size(); ++i) {
    const RecordScalar& scalar = layout_.scalars[i];
    if (holds_all(scalar.field.type)) {
      load_column(scalar.field, layout_.swapped, base, first, rows, column.data());
    } else {
      load_column(scalar.field, layout_.swapped, base, first, rows, wide.data());
      for (std::size_t row = 0; row < rows; ++row) {
        losses_[i].see(wide[row]);
        column[row] = static_cast<float>(wide[row]);
      }
    }
    if (scalar.mask != 255) {
      for (std::size_t row = 0; row < rows; ++row)
        column[row] = static_cast<float>(static_cast<std::uint8_t>(column[row]) & scalar.mask);
    }
    std::vector<float>& values = cloud_.scalars[i].values;
    values.insert(values.end(), column.begin(), column.begin() + static_cast<std::ptrdiff_t>(rows));
  }
}

/// Floats are exact as they are, so the origin is moved only where that gains something.
void RecordCollector::move_far_origin() {
  if (!(low_.x <= high_.x)) return;
  const glm::dvec3 low(low_), high(high_);
  const glm::dvec3 reach = glm::max(glm::abs(low), glm::abs(high)), extent = high - low;
  if (std::max({reach.x, reach.y, reach.z}) <= 2.0 * std::max({extent.x, extent.y, extent.z}))
    return;
  cloud_.origin = low;
  for (glm::vec3& p : cloud_.positions) p = glm::vec3(glm::dvec3(p) - low);
}

void RecordCollector::finish_colors(ReadNotes& notes) {
  if (!layout_.color) return;
  if (is_float((*layout_.color)[0].type)) {
    float largest = 0.0f;
    for (const glm::vec3& c : float_colors_)
      for (int i = 0; i < 3; ++i)
        if (c[i] > largest) largest = c[i];
    const double full = choose_full_color(largest, true, notes);
    cloud_.colors.reserve(float_colors_.size());
    for (const glm::vec3& c : float_colors_)
      cloud_.colors.emplace_back(color_of(c.x, full), color_of(c.y, full), color_of(c.z, full));
  } else if (is_wide((*layout_.color)[0].type)) {
    const double full = choose_full_color(brightest_, false, notes);
    if (full == 65535.0) return;
    for (glm::u16vec3& c : cloud_.colors)
      c = glm::u16vec3(color_of(c.x, full), color_of(c.y, full), color_of(c.z, full));
  }
}

PointCloud RecordCollector::finish(ReadNotes& notes) {
  if (positions_ == Positions::floats) move_far_origin();
  finish_colors(notes);
  for (std::size_t i = 0; i < losses_.size(); ++i)
    if (const auto line = losses_[i].warning(cloud_.scalars[i].name))
      notes.warnings.push_back(*line);
  return std::move(cloud_);
}

Result<PointCloud> read_records(const ByteSource& source, const RecordTable& table,
                                const RecordLayout& layout, ReadNotes& notes) {
  const std::uint64_t left = source.size() - std::min(source.size(), table.begin);
  const auto ends = [&](std::uint64_t at, std::uint64_t whole) {
    return fail(concat("byte ", at, ": the data end within point ", whole, " of ", table.count));
  };
  if (table.count > left / table.size) return ends(source.size(), left / table.size);
  RecordCollector collector(layout, static_cast<std::size_t>(table.count));
  const std::size_t block = std::max<std::size_t>(1, kBlockBytes / table.size);
  Bytes room;
  for (std::uint64_t row = 0; row < table.count; row += block) {
    const auto rows = static_cast<std::size_t>(std::min<std::uint64_t>(block, table.count - row));
    const std::uint64_t at = table.begin + row * table.size;
    const ByteView bytes = TRY(source.view(at, rows * table.size, room));
    if (bytes.size() < rows * table.size)
      return ends(at + bytes.size(), row + bytes.size() / table.size);
    collector.add(bytes.data(), 0, rows);
  }
  return collector.finish(notes);
}

}  // namespace pointreel
