#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "pointreel/bytes.h"
#include "pointreel/up.h"

/// The formats of files of points: their names, and how they are recognised.
namespace pointreel {

enum class CloudFormat : std::uint8_t {
  unknown,
  ply,
  drc,
  pcd,
  las,
  text,
  obj,
  gltf,
  numpy,           ///< .npy or .npz
  sweep,           ///< KITTI's, or one whose name does not tell
  nuscenes_sweep,  ///< five floats a point
  mcap,            ///< many clouds, each a point_cloud2
  point_cloud2,    ///< a message of ROS 2
  depth_video,     ///< many pictures of depth, each a depth_frame
  depth_frame,     ///< a picture of depth with what belongs to it (depth_frame.h)
  foreign,         ///< known, but not read: the error says how to convert it
};

/// Recognised by the first bytes (about a hundred suffice), or else by the end of the name, which
/// may be empty.
CloudFormat format_of(ByteView begin, std::string_view name);

/// How likely a file of that name holds points.
enum class Likely : std::uint8_t {
  no,
  maybe,  ///< .txt, .csv, .bin: other files are called so, too
  yes
};
Likely is_cloud_name(std::string_view name);

/// The axis that points up in all files of a format; nothing if it differs.
std::optional<Up> up_of(CloudFormat format);

/// Whether points without a position are usual in files of that format: they were not measured.
bool has_empty_points(CloudFormat format);

/// "PLY, Draco, ..., MCAP and depth video", for people.
std::string known_formats();

}  // namespace pointreel
