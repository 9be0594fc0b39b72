#include <algorithm>
#include <cstring>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "codec/files/attribute_names.h"
#include "codec/files/ply.h"
#include "common/base/letter_case.h"
#include "common/file_system/write_file.h"

namespace pointreel {
namespace {

template <class T>
std::uint8_t* put(std::uint8_t* at, T value) {
  std::memcpy(at, &value, sizeof(T));
  return at + sizeof(T);
}

template <class T, int N, class V>
std::uint8_t* put_vector(std::uint8_t* at, const glm::vec<N, V>& v) {
  for (int i = 0; i < N; ++i) at = put(at, static_cast<T>(v[i]));
  return at;
}

/// The names, in small letters, that read_ply may take for another attribute.
std::set<std::string, std::less<>> names_of_attributes() {
  std::set<std::string, std::less<>> names = {"x", "y", "z", "radius", "f_dc_0"};
  for (const VectorNames& three : kNormalNames) names.insert(three.begin(), three.end());
  for (const VectorNames& three : kColorNames) names.insert(three.begin(), three.end());
  names.insert(kPackedColorNames.begin(), kPackedColorNames.end());
  return names;
}

/// Names for the scalar fields that a PLY header can hold, and that read_ply gives to no other
/// attribute.
std::vector<std::string> names_of(const std::vector<ScalarField>& scalars) {
  const auto attributes = names_of_attributes();
  std::set<std::string> taken;
  std::vector<std::string> names;
  for (const ScalarField& field : scalars) {
    std::string name = field.name;
    std::replace(name.begin(), name.end(), ' ', '_');
    while (attributes.contains(in_small_letters(name)) || !taken.insert(name).second)
      name.insert(0, "scalar_");
    names.push_back(name);
  }
  return names;
}

/// Faces of null: the file has no such element, as clouds have none.
Bytes bytes_of(const PointCloud& cloud, const std::span<const glm::uvec3>* faces) {
  const bool as_float = world_fits_float(cloud);
  const bool as_bytes = colors_fit_8_bits(cloud);
  std::size_t row_size = as_float ? 12 : 24;
  std::string header =
      fmt::format("ply\nformat binary_little_endian 1.0\nelement vertex {}\n", cloud.size());
  const auto declare = [&header](const char* type, std::initializer_list<const char*> names) {
    for (const char* name : names) header += fmt::format("property {} {}\n", type, name);
  };
  declare(as_float ? "float" : "double", {"x", "y", "z"});
  if (cloud.has_normals()) {
    declare("float", {"nx", "ny", "nz"});
    row_size += 12;
  }
  if (cloud.has_colors()) {
    declare(as_bytes ? "uchar" : "ushort", {"red", "green", "blue"});
    row_size += as_bytes ? 3 : 6;
  }
  if (cloud.has_radii()) {
    declare("float", {"radius"});
    row_size += 4;
  }
  for (const std::string& name : names_of(cloud.scalars)) declare("float", {name.c_str()});
  row_size += 4 * cloud.scalars.size();
  std::size_t face_bytes = 0;
  if (faces != nullptr) {
    header +=
        fmt::format("element face {}\nproperty list uchar uint vertex_indices\n", faces->size());
    face_bytes = 13 * faces->size();
  }
  header += "end_header\n";

  Bytes bytes(header.size() + row_size * cloud.size() + face_bytes);
  std::uint8_t* at = std::copy(header.begin(), header.end(), bytes.data());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    at = as_float ? put_vector<float>(at, cloud.world(i)) : put_vector<double>(at, cloud.world(i));
    if (cloud.has_normals()) at = put_vector<float>(at, cloud.normals[i]);
    if (cloud.has_colors()) {
      const glm::u16vec3& color = cloud.colors[i];
      at = as_bytes ? put_vector<std::uint8_t>(at, color / std::uint16_t{257})
                    : put_vector<std::uint16_t>(at, color);
    }
    if (cloud.has_radii()) at = put(at, cloud.radii[i]);
    for (const ScalarField& field : cloud.scalars) at = put(at, field.values[i]);
  }
  if (faces != nullptr) {
    for (const glm::uvec3& triangle : *faces)
      at = put_vector<std::uint32_t>(put(at, std::uint8_t{3}), triangle);
  }
  return bytes;
}

}  // namespace

bool world_fits_float(const PointCloud& cloud) {
  if (cloud.origin == glm::dvec3(0.0)) return true;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::dvec3 p = cloud.world(i);
    for (int axis = 0; axis < 3; ++axis) {
      if (p[axis] - p[axis] == 0.0 && static_cast<double>(static_cast<float>(p[axis])) != p[axis]) {
        return false;
      }
    }
  }
  return true;
}

Bytes ply_bytes(const PointCloud& cloud) { return bytes_of(cloud, nullptr); }

Bytes ply_bytes(const PointCloud& vertices, std::span<const glm::uvec3> triangles) {
  return bytes_of(vertices, &triangles);
}

Result<void> write_ply(const std::filesystem::path& path, const PointCloud& cloud) {
  return write_file(path, ply_bytes(cloud));
}

}  // namespace pointreel
