#include "codec/files/write_cloud.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <zlib.h>

#include "codec/files/ply.h"
#include "codec/files/point_records.h"
#include "common/base/byte_io.h"
#include "pointreel/version.h"

namespace pointreel {
namespace {

void put_text(Bytes& out, std::string_view text) {
  out.insert(out.end(), text.begin(), text.end());
}

const ScalarField* find_scalar(const PointCloud& cloud, std::string_view name) {
  const auto found = std::find_if(cloud.scalars.begin(), cloud.scalars.end(),
                                  [&](const ScalarField& field) { return field.name == name; });
  return found == cloud.scalars.end() ? nullptr : &*found;
}

/// A scalar field that LAS has, with the bounds of its values.
struct LasField {
  std::string_view name;
  int least = 0, most = 0;
};
constexpr LasField kIntensity{"intensity", 0, 65535}, kReturnNumber{"return number", 1, 7},
    kClassification{"classification", 0, 31};

/// A value as a whole number within bounds; the least where there is none.
int rounded(const ScalarField* field, std::size_t i, const LasField& las) {
  if (field == nullptr || !(field->values[i] > static_cast<float>(las.least))) return las.least;
  return static_cast<int>(std::min(std::round(field->values[i]), static_cast<float>(las.most)));
}

/// An array of numpy.
struct Array {
  std::string name;
  Bytes bytes;
};

/// `descr`: the type, as "<f8". `shape`: as numpy writes it.
Bytes array_head(const char* descr, const std::string& shape) {
  std::string text =
      fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': {}, }}", descr, shape);
  // The numbers begin at a multiple of 64.
  constexpr std::size_t kBefore = 10;
  while ((kBefore + text.size() + 1) % 64 != 0) text += ' ';
  text += '\n';
  const std::string before{'\x93',
                           'N',
                           'U',
                           'M',
                           'P',
                           'Y',
                           1,
                           0,
                           static_cast<char>(text.size() & 255),
                           static_cast<char>(text.size() >> 8)};
  text.insert(0, before);
  return Bytes(text.begin(), text.end());
}

/// An array of vectors, or of numbers.
template <class T, class Vector>
Array array_of(const std::string& name, const char* descr, const std::vector<Vector>& vectors) {
  constexpr bool kOne = sizeof(Vector) == sizeof(T);
  static_assert(kOne || sizeof(Vector) == 3 * sizeof(T));
  Array array{name + ".npy",
              array_head(descr, fmt::format("({}{})", vectors.size(), kOne ? "," : ", 3"))};
  const std::size_t at = array.bytes.size();
  array.bytes.resize(at + vectors.size() * sizeof(Vector));
  if (!vectors.empty())
    std::memcpy(array.bytes.data() + at, vectors.data(), vectors.size() * sizeof(Vector));
  return array;
}

/// A ZIP archive whose files are stored as they are. Less than 4 GiB.
Bytes zip_of(const std::vector<Array>& arrays) {
  constexpr std::uint16_t kVersion = 20, kStored = 0;
  constexpr std::uint32_t kDate = 33u << 16;  // 1 January 1980, so that bytes do not vary
  Bytes bytes, directory;
  // What the local and the central header have in common.
  const auto put_entry = [&](Bytes& to, const Array& array, std::uint32_t checksum) {
    ByteWriter out(to);
    out.put(kVersion);
    out.put(std::uint16_t{0});
    out.put(kStored);
    out.put(kDate);
    out.put(checksum);
    out.put(static_cast<std::uint32_t>(array.bytes.size()));
    out.put(static_cast<std::uint32_t>(array.bytes.size()));
    out.put(static_cast<std::uint16_t>(array.name.size()));
    out.put(std::uint16_t{0});
  };
  for (const Array& array : arrays) {
    const auto checksum =
        static_cast<std::uint32_t>(crc32_z(0, array.bytes.data(), array.bytes.size()));
    const auto begin = static_cast<std::uint32_t>(bytes.size());
    ByteWriter(bytes).put(std::uint32_t{0x04034b50});
    put_entry(bytes, array, checksum);
    put_text(bytes, array.name);
    bytes.insert(bytes.end(), array.bytes.begin(), array.bytes.end());

    ByteWriter central(directory);
    central.put(std::uint32_t{0x02014b50});
    central.put(kVersion);
    put_entry(directory, array, checksum);
    central.put(std::uint16_t{0});  // comment
    central.put(std::uint16_t{0});  // disk
    central.put(std::uint16_t{0});
    central.put(std::uint32_t{0});
    central.put(begin);
    put_text(directory, array.name);
  }
  const auto begin = static_cast<std::uint32_t>(bytes.size());
  bytes.insert(bytes.end(), directory.begin(), directory.end());
  ByteWriter out(bytes);
  out.put(std::uint32_t{0x06054b50});
  out.put(std::uint32_t{0});  // disks
  out.put(static_cast<std::uint16_t>(arrays.size()));
  out.put(static_cast<std::uint16_t>(arrays.size()));
  out.put(static_cast<std::uint32_t>(directory.size()));
  out.put(begin);
  out.put(std::uint16_t{0});
  return bytes;
}

}  // namespace

const char* extension(PointsFormat format) {
  switch (format) {
    case PointsFormat::ply:
      return ".ply";
    case PointsFormat::pcd:
      return ".pcd";
    case PointsFormat::las:
      return ".las";
    case PointsFormat::npz:
      break;
  }
  return ".npz";
}

Bytes pcd_bytes(const PointCloud& cloud) {
  std::string names, sizes, types, counts;
  for (const RecordColumn& column : record_columns(cloud)) {
    names += " " + column.name;
    sizes += fmt::format(" {}", column.bytes());
    types += column.type == RecordColumn::Type::rgb ? " U" : " F";
    counts += " 1";
  }
  Bytes bytes;
  put_text(bytes, fmt::format("# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS{}\n"
                              "SIZE{}\nTYPE{}\nCOUNT{}\nWIDTH {}\nHEIGHT 1\n"
                              "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {}\nDATA binary\n",
                              names, sizes, types, counts, cloud.size(), cloud.size()));
  put_records(cloud, bytes);
  return bytes;
}

Bytes las_bytes(const PointCloud& cloud) {
  constexpr std::size_t kHeader = 227, kWithColor = 26, kPlain = 20;
  const std::size_t size = cloud.has_colors() ? kWithColor : kPlain;
  const Box box = cloud.empty() ? Box{glm::dvec3(0.0), glm::dvec3(0.0)} : bounds(cloud);
  const glm::dvec3 extent = box.max - box.min;
  const double longest = std::max({extent.x, extent.y, extent.z});
  const double scale =
      longest > 0.0 ? std::pow(10.0, std::floor(std::log10(longest * 0x1p-26))) : 0.001;
  // As round as the coordinates, which count from there, leave room for: a whole number, unless all
  // of it is small.
  const double round = std::min(1.0, 1e8 * scale);
  const glm::dvec3 offset = glm::floor(box.min / round) * round;

  Bytes bytes(kHeader + size * cloud.size());
  const auto set = [&](std::size_t at, auto value) {
    std::memcpy(bytes.data() + at, &value, sizeof(value));
  };
  std::memcpy(bytes.data(), "LASF", 4);
  set(24, std::uint8_t{1});
  set(25, std::uint8_t{2});
  constexpr std::string_view kSystem = "OTHER", kSoftware = "Pointreel " POINTREEL_VERSION;
  std::memcpy(bytes.data() + 26, kSystem.data(), kSystem.size());
  std::memcpy(bytes.data() + 58, kSoftware.data(), std::min<std::size_t>(kSoftware.size(), 32));
  set(94, static_cast<std::uint16_t>(kHeader));
  set(96, static_cast<std::uint32_t>(kHeader));
  set(104, static_cast<std::uint8_t>(cloud.has_colors() ? 2 : 0));
  set(105, static_cast<std::uint16_t>(size));
  set(107, static_cast<std::uint32_t>(cloud.size()));
  set(111, static_cast<std::uint32_t>(cloud.size()));  // first returns
  for (int axis = 0; axis < 3; ++axis) {
    const auto at = static_cast<std::size_t>(8 * axis);
    set(131 + at, scale);
    set(155 + at, offset[axis]);
    set(179 + 2 * at, box.max[axis]);
    set(187 + 2 * at, box.min[axis]);
  }
  const ScalarField* const intensity = find_scalar(cloud, kIntensity.name);
  const ScalarField* const returns = find_scalar(cloud, kReturnNumber.name);
  const ScalarField* const classes = find_scalar(cloud, kClassification.name);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const std::size_t at = kHeader + size * i;
    const glm::dvec3 p = (cloud.world(i) - offset) / scale;
    for (int axis = 0; axis < 3; ++axis)
      set(at + static_cast<std::size_t>(4 * axis),
          static_cast<std::int32_t>(std::llround(p[axis])));
    set(at + 12, static_cast<std::uint16_t>(rounded(intensity, i, kIntensity)));
    const int number = rounded(returns, i, kReturnNumber);
    set(at + 14, static_cast<std::uint8_t>(number | number << 3));  // the last return
    set(at + 15, static_cast<std::uint8_t>(rounded(classes, i, kClassification)));
    for (int c = 0; c < 3 && cloud.has_colors(); ++c)
      set(at + 20 + static_cast<std::size_t>(2 * c), cloud.colors[i][c]);
  }
  return bytes;
}

std::vector<LostValues> lost_in_las(const PointCloud& cloud) {
  std::vector<LostValues> all;
  for (const ScalarField& field : cloud.scalars) {
    LostValues lost{field.name, field.values.size(), std::nullopt};
    for (const LasField& las : {kIntensity, kReturnNumber, kClassification}) {
      if (las.name != field.name) continue;
      lost.bounds = {las.least, las.most};
      lost.values = static_cast<std::uint64_t>(
          std::count_if(field.values.begin(), field.values.end(), [&](float value) {
            const float whole = std::round(value);
            return !(whole >= static_cast<float>(las.least) &&
                     whole <= static_cast<float>(las.most));
          }));
    }
    if (lost.values > 0) all.push_back(std::move(lost));
  }
  return all;
}

Result<Bytes> npz_bytes(const PointCloud& cloud) {
  constexpr std::uint64_t kRow =
      sizeof(glm::dvec3) + sizeof(glm::u16vec3) + sizeof(glm::vec3) + kMaxScalars * sizeof(float);
  if (cloud.size() * kRow > std::numeric_limits<std::uint32_t>::max() - (1u << 16))
    return fail(ErrorCode::limit, "the frame has too many points for a .npz file of 4 GiB");
  std::vector<glm::dvec3> world(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) world[i] = cloud.world(i);
  std::vector<Array> arrays{array_of<double>("positions", "<f8", world)};
  if (cloud.has_colors()) arrays.push_back(array_of<std::uint16_t>("colors", "<u2", cloud.colors));
  if (cloud.has_normals()) arrays.push_back(array_of<float>("normals", "<f4", cloud.normals));
  std::vector<std::string> names{"positions", "colors", "normals"};
  for (const ScalarField& field : cloud.scalars) {
    const bool taken = std::find(names.begin(), names.begin() + 3, field.name) != names.begin() + 3;
    names.push_back(word_name((taken ? "scalar_" : "") + field.name, names));
    arrays.push_back(array_of<float>(names.back(), "<f4", field.values));
  }
  return zip_of(arrays);
}

Result<Bytes> cloud_bytes(const PointCloud& cloud, PointsFormat format) {
  switch (format) {
    case PointsFormat::ply:
      return ply_bytes(cloud);
    case PointsFormat::pcd:
      return pcd_bytes(cloud);
    case PointsFormat::las:
      return las_bytes(cloud);
    case PointsFormat::npz:
      break;
  }
  return npz_bytes(cloud);
}

}  // namespace pointreel
