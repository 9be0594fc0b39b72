#include "codec/files/format_table.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "codec/draco/drc_reader.h"
#include "codec/files/depth_frame.h"
#include "codec/files/gltf.h"
#include "codec/files/las.h"
#include "codec/files/mcap.h"
#include "codec/files/numpy.h"
#include "codec/files/obj.h"
#include "codec/files/pcd.h"
#include "codec/files/ply.h"
#include "codec/files/point_cloud2.h"
#include "codec/files/sweep.h"
#include "codec/files/text_points.h"
#include "common/base/concat.h"
#include "common/base/letter_case.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

using Read = Result<PointCloud> (*)(const ByteSource&, const DecodeLimits&, const Reading&,
                                    ReadNotes&);

Result<PointCloud> read_whole_ply(const ByteSource& source, const DecodeLimits&, const Reading&,
                                  ReadNotes& notes) {
  Bytes room;
  return read_ply(TRY(source.all(room)), &notes);
}

Result<PointCloud> read_whole_drc(const ByteSource& source, const DecodeLimits& limits,
                                  const Reading&, ReadNotes& notes) {
  Bytes room;
  return read_drc(TRY(source.all(room)), limits, &notes.unread);
}

template <auto kRead>
Result<PointCloud> read_unlimited(const ByteSource& source, const DecodeLimits&, const Reading&,
                                  ReadNotes& notes) {
  return kRead(source, notes);
}

template <auto kRead>
Result<PointCloud> read_limited(const ByteSource& source, const DecodeLimits& limits,
                                const Reading&, ReadNotes& notes) {
  return kRead(source, limits, notes);
}

template <auto kRead>
Result<PointCloud> read_as(const ByteSource& source, const DecodeLimits&, const Reading& reading,
                           ReadNotes& notes) {
  return kRead(source, reading, notes);
}

Result<PointCloud> read_nuscenes(const ByteSource& source, const DecodeLimits&,
                                 const Reading& reading, ReadNotes& notes) {
  if (!reading.columns.empty()) return read_sweep(source, reading, notes);
  return read_sweep(source, {nuscenes_columns(), reading.full_color}, notes);
}

Result<PointCloud> refuse_recording(const ByteSource&, const DecodeLimits&, const Reading&,
                                    ReadNotes&) {
  return fail(ErrorCode::unsupported,
              "is an MCAP recording of many clouds: pack it, or play it under a name that ends in "
              ".mcap");
}

Result<PointCloud> refuse_video(const ByteSource&, const DecodeLimits&, const Reading&,
                                ReadNotes&) {
  return fail(ErrorCode::unsupported,
              "is a video: pack it, or play it under a name that ends in .mkv, if it is of depth");
}

Result<PointCloud> refuse_picture(const ByteSource&, const DecodeLimits&, const Reading&,
                                  ReadNotes&) {
  return fail(ErrorCode::unsupported,
              "is a picture: to read depth, name the folder that has depth/*.png and intrinsics");
}

Result<PointCloud> refuse_bag(const ByteSource&, const DecodeLimits&, const Reading&, ReadNotes&) {
  return fail(ErrorCode::unsupported,
              "is a bag of ROS 1 or in SQLite, which is not read: convert it to MCAP with "
              "\"rosbags-convert --src IN --dst OUT --dst-storage mcap\" (of PyPI's rosbags)");
}

Result<PointCloud> refuse_e57(const ByteSource&, const DecodeLimits&, const Reading&, ReadNotes&) {
  return fail(
      ErrorCode::unsupported,
      "is an E57 file, which is not read: convert it with \"pdal translate IN.e57 OUT.las\"");
}

/// All formats. What else is to be known about one stands in its row.
struct Row {
  CloudFormat format;
  const char* name;                        ///< for people
  std::array<const char*, 7> endings;      ///< of file names, in small letters
  std::array<std::string_view, 2> begins;  ///< what files begin with
  Likely by_name;                          ///< for names with these endings
  Read read;
  std::optional<Up> up = {};
  bool empty_points = false;
};

constexpr Row kFormats[] = {
    {CloudFormat::ply, "PLY", {".ply"}, {"ply", "PLY"}, Likely::yes, read_whole_ply},
    {CloudFormat::drc, "Draco", {".drc"}, {"DRACO"}, Likely::yes, read_whole_drc},
    // Before .bin, with which the name ends, too.
    {CloudFormat::nuscenes_sweep, "nuScenes", {".pcd.bin"}, {}, Likely::yes, read_nuscenes, 'z'},
    {CloudFormat::pcd,
     "PCD",
     {".pcd"},
     {"# .PCD", "VERSION"},
     Likely::yes,
     read_unlimited<read_pcd>,
     std::nullopt,
     true},
    {CloudFormat::las,
     "LAS",
     {".las", ".laz"},
     {"LASF"},
     Likely::yes,
     read_unlimited<read_las>,
     'z'},
    {CloudFormat::text,
     "text",
     {".xyz", ".xyzn", ".xyzrgb", ".pts", ".asc", ".txt", ".csv"},
     {},
     Likely::maybe,
     read_as<read_text_points>},
    {CloudFormat::obj, "OBJ", {".obj"}, {}, Likely::yes, read_unlimited<read_obj>},
    {CloudFormat::gltf,
     "glTF",
     {".glb", ".gltf"},
     {"glTF"},
     Likely::yes,
     read_limited<read_gltf>,
     'y'},
    {CloudFormat::numpy,
     "numpy",
     {".npz", ".npy"},
     {"\x93NUMPY", "PK\x03\x04"},
     Likely::maybe,
     read_numpy},
    {CloudFormat::sweep, "KITTI", {".bin"}, {}, Likely::maybe, read_as<read_sweep>, 'z'},
    {CloudFormat::mcap, "MCAP", {".mcap"}, {"\x89MCAP0"}, Likely::yes, refuse_recording, 'z', true},
    {CloudFormat::point_cloud2,
     "PointCloud2",
     {},
     {},
     Likely::no,
     read_unlimited<read_point_cloud2>,
     'z',
     true},
    {CloudFormat::depth_video,
     "depth video",
     {".mkv"},
     {"\x1a\x45\xdf\xa3"},
     Likely::maybe,
     refuse_video,
     'y'},
    {CloudFormat::depth_frame, "depth", {}, {}, Likely::no, read_limited<read_depth_frame>, 'y'},
    {CloudFormat::foreign, "", {}, {"\x89PNG"}, Likely::no, refuse_picture},
    {CloudFormat::foreign, "", {}, {"#ROSBAG", "SQLite format 3"}, Likely::no, refuse_bag},
    {CloudFormat::foreign, "", {}, {"ASTM-E57"}, Likely::no, refuse_e57},
};

static_assert(std::all_of(std::begin(kFormats), std::end(kFormats), [](const Row& row) {
  return !row.up || (row.up->axis() >= 0 && row.up->axis() <= 2);
}));

/// Endings of formats with more than one that nothing else uses.
constexpr std::array<std::string_view, 5> kSureText{".xyz", ".xyzn", ".xyzrgb", ".pts", ".asc"};

const Row* find(CloudFormat format) {
  const auto row = std::find_if(std::begin(kFormats), std::end(kFormats),
                                [=](const Row& r) { return r.format == format; });
  return row == std::end(kFormats) ? nullptr : &*row;
}

/// The row whose ending the name has, and that ending.
const Row* find_by_name(std::string_view name, std::string_view& ending) {
  const std::string small = in_small_letters(name);
  for (const Row& row : kFormats) {
    for (const char* candidate : row.endings) {
      if (candidate == nullptr || !small.ends_with(candidate)) continue;
      ending = candidate;
      return &row;
    }
  }
  return nullptr;
}

bool begins_with(ByteView bytes, std::string_view text) {
  return !text.empty() && bytes.size() >= text.size() &&
         std::memcmp(bytes.data(), text.data(), text.size()) == 0;
}

const Row* find_by_begin(ByteView begin) {
  for (const Row& row : kFormats) {
    for (const std::string_view expected : row.begins)
      if (begins_with(begin, expected)) return &row;
  }
  return nullptr;
}

/// Why a file whose format is known by its name alone is not of that format; empty if it may be.
std::string fault_of_begin(const Row& row, const ByteView begin) {
  if (row.begins[0].empty()) return {};
  // Other PCD files begin with a comment or a field, and .gltf files are JSON.
  if (row.format == CloudFormat::pcd || row.format == CloudFormat::gltf) return {};
  if (begins_with(begin, row.begins[0]) || begins_with(begin, row.begins[1])) return {};
  return concat("is not a ", row.name, " file: it does not begin with \"", row.begins[0], "\"");
}

}  // namespace

CloudFormat format_of(ByteView begin, std::string_view name) {
  std::string_view ending;
  const Row* row = find_by_begin(begin);
  if (row == nullptr) row = find_by_name(name, ending);
  return row == nullptr ? CloudFormat::unknown : row->format;
}

Likely is_cloud_name(std::string_view name) {
  std::string_view ending;
  const Row* row = find_by_name(name, ending);
  if (row == nullptr) return Likely::no;
  const bool sure = std::find(kSureText.begin(), kSureText.end(), ending) != kSureText.end();
  return sure ? Likely::yes : row->by_name;
}

std::optional<Up> up_of(CloudFormat format) {
  const Row* row = find(format);
  return row != nullptr ? row->up : std::nullopt;
}

bool has_empty_points(CloudFormat format) {
  const Row* row = find(format);
  return row != nullptr && row->empty_points;
}

std::string known_formats() {
  std::vector<std::string_view> names;
  for (const Row& row : kFormats) {
    if (row.by_name != Likely::no) names.push_back(row.name);
  }
  std::string text(names.front());
  for (std::size_t i = 1; i < names.size(); ++i)
    text += concat(i + 1 < names.size() ? ", " : " and ", names[i]);
  return text;
}

Result<PointCloud> read_points(const ByteSource& source, CloudFormat format,
                               const DecodeLimits& limits, const Reading& reading,
                               ReadNotes& notes) {
  if (source.size() == 0) return fail("the file is empty");
  Bytes room;
  const ByteView begin = TRY(source.view(0, 16, room));
  const Row* row = format == CloudFormat::foreign ? find_by_begin(begin) : find(format);
  if (row == nullptr) {
    return fail(
        concat("is not a known point cloud file, by its first bytes or by its name; known are ",
               known_formats()));
  }
  if (std::string fault = fault_of_begin(*row, begin); !fault.empty())
    return fail(std::move(fault));
  notes.full_color = reading.full_color;
  return row->read(source, limits, reading, notes);
}

}  // namespace pointreel
