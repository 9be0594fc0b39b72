#include "codec/files/point_records.h"

#include <algorithm>
#include <cstring>

#include "codec/files/ply.h"

namespace pointreel {
namespace {

std::uint32_t to_8_bits(std::uint16_t color) { return (color + 128u) / 257u; }

/// Programs of ROS and PCL mostly want floats.
bool suits_float(const PointCloud& cloud) {
  if (world_fits_float(cloud)) return true;
  const Box box = bounds(cloud);
  const glm::dvec3 reach = glm::max(glm::abs(box.min), glm::abs(box.max)), extent = box.extent();
  return std::max({reach.x, reach.y, reach.z}) <= 2.0 * std::max({extent.x, extent.y, extent.z});
}

}  // namespace

std::string word_name(const std::string& name, const std::vector<std::string>& taken) {
  std::string word = name;
  for (char& c : word) {
    const bool good = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                      c == '_' || c == '-';
    if (!good) c = '_';
  }
  while (std::find(taken.begin(), taken.end(), word) != taken.end()) word += '_';
  return word;
}

std::vector<RecordColumn> record_columns(const PointCloud& cloud) {
  using Type = RecordColumn::Type;
  const Type position = suits_float(cloud) ? Type::float32 : Type::float64;
  std::vector<RecordColumn> columns{{"x", position}, {"y", position}, {"z", position}};
  if (cloud.has_normals()) {
    for (const char* name : {"normal_x", "normal_y", "normal_z"})
      columns.push_back({name, Type::float32});
  }
  if (cloud.has_colors()) columns.push_back({"rgb", Type::rgb});
  std::vector<std::string> names;
  for (const RecordColumn& column : columns) names.push_back(column.name);
  for (const ScalarField& field : cloud.scalars) {
    names.push_back(word_name(field.name, names));
    columns.push_back({names.back(), Type::float32});
  }
  return columns;
}

void put_records(const PointCloud& cloud, Bytes& out) {
  const std::vector<RecordColumn> columns = record_columns(cloud);
  const bool as_float = columns.front().type == RecordColumn::Type::float32;
  std::size_t record = 0;
  for (const RecordColumn& column : columns) record += column.bytes();
  const std::size_t begin = out.size();
  out.resize(begin + record * cloud.size());
  std::uint8_t* at = out.data() + begin;
  const auto put = [&at](const auto& value) {
    std::memcpy(at, &value, sizeof(value));
    at += sizeof(value);
  };
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::dvec3 p = cloud.world(i);
    if (as_float) {
      put(glm::vec3(p));
    } else {
      put(p);
    }
    if (cloud.has_normals()) put(cloud.normals[i]);
    if (cloud.has_colors()) {
      const glm::u16vec3& c = cloud.colors[i];
      put(to_8_bits(c.x) << 16 | to_8_bits(c.y) << 8 | to_8_bits(c.z));
    }
    for (const ScalarField& scalar : cloud.scalars) put(scalar.values[i]);
  }
}

}  // namespace pointreel
