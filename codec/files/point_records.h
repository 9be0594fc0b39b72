#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "pointreel/bytes.h"
#include "pointreel/cloud.h"

/// Points as binary PCD files and PointCloud2 messages have them: one record for each point, of
/// named numbers that follow each other.
namespace pointreel {

struct RecordColumn {
  enum class Type : std::uint8_t { float32, float64, rgb };
  std::string name;
  Type type = Type::float32;
  std::size_t bytes() const { return type == Type::float64 ? 8 : 4; }
};

/// x, y, z as floats, or as doubles where the points are so far from zero that floats would lose
/// more than 2^-23 of the longest extent; normal_x, normal_y, normal_z;
/// rgb, which is 0x00RRGGBB, rounded to 8 bits; scalar fields as floats. No two have the same name.
std::vector<RecordColumn> record_columns(const PointCloud& cloud);

/// Appends the numbers of all points in world coordinates, in the order of the columns.
void put_records(const PointCloud& cloud, Bytes& out);

/// Makes a word of letters, digits, '_' and '-' of a scalar field's name, which is not in `taken`.
std::string word_name(const std::string& name, const std::vector<std::string>& taken);

}  // namespace pointreel
