#include "codec/files/depth_frame.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "codec/files/camera_intrinsics.h"
#include "codec/files/depth_points.h"
#include "codec/files/picture.h"
#include "common/base/byte_io.h"
#include "common/base/concat.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

constexpr std::uint64_t kDepthMemory = 64, kColorMemory = 8;  ///< bytes for each pixel

/// Whether two pictures can show the same: their sides are in the same proportion.
bool same_shape(double width, double height, double other_width, double other_height) {
  return std::abs(width * other_height / (height * other_width) - 1.0) <= 0.01;
}

std::string size_text(std::uint32_t width, std::uint32_t height) {
  return concat(width, " x ", height);
}

/// The camera as it would be with as many pixels as the picture has.
Result<CameraIntrinsics> camera_of(CameraIntrinsics camera, const DepthPicture& depth) {
  if (camera.width == depth.width && camera.height == depth.height) return camera;
  if (camera.width == 0) {
    // Of the same camera with more pixels, if not of a part of its picture.
    if (camera.cx < 0.0 || camera.cy < 0.0 || camera.cx > depth.width - 1.0 ||
        camera.cy > depth.height - 1.0) {
      return fail(concat("have their centre at ", camera.cx, " ", camera.cy,
                         ", outside of the depth's ", size_text(depth.width, depth.height),
                         " pixels; say by width and height for which pictures they hold"));
    }
    return camera;
  }
  if (!same_shape(camera.width, camera.height, depth.width, depth.height)) {
    return fail(concat("are for ", size_text(camera.width, camera.height),
                       " pixels, but the depth has ", size_text(depth.width, depth.height),
                       "; give those of the camera of depth"));
  }
  const double x = static_cast<double>(depth.width) / camera.width,
               y = static_cast<double>(depth.height) / camera.height;
  camera.fx *= x;
  camera.fy *= y;
  // Coordinates count from the centre of the first pixel.
  camera.cx = (camera.cx + 0.5) * x - 0.5;
  camera.cy = (camera.cy + 0.5) * y - 0.5;
  return camera;
}

/// How many pixels may be read where each takes so much memory.
std::uint64_t most_pixels(std::uint64_t most_points, std::uint64_t memory, std::uint64_t each) {
  return std::min(most_points, memory / each);
}

/// The picture, or the error that it has too many pixels; if it is for lack of memory, with the
/// advice of MemoryBudget.
template <class Picture>
Result<Picture> with_advice(Result<Picture> read, std::uint64_t most, std::uint64_t most_points) {
  if (read || read.error().code != ErrorCode::limit || most >= most_points) return read;
  return fail(ErrorCode::limit,
              read.error().message + "; raise --frame-memory if you trust where it comes from");
}

}  // namespace

Bytes depth_frame(std::string_view intrinsics, ByteView depth, ByteView color) {
  Bytes bytes;
  bytes.reserve(2 * sizeof(std::uint32_t) + intrinsics.size() + depth.size() + color.size());
  ByteWriter out(bytes);
  out.put(static_cast<std::uint32_t>(intrinsics.size()));
  out.put(static_cast<std::uint32_t>(depth.size()));
  bytes.insert(bytes.end(), intrinsics.begin(), intrinsics.end());
  bytes.insert(bytes.end(), depth.begin(), depth.end());
  bytes.insert(bytes.end(), color.begin(), color.end());
  return bytes;
}

Result<PointCloud> read_depth_frame(const ByteSource& source, const DecodeLimits& limits,
                                    ReadNotes& notes) {
  Bytes room;
  ByteReader reader(TRY(source.all(room)));
  const auto intrinsics_size = reader.get<std::uint32_t>();
  const auto depth_size = reader.get<std::uint32_t>();
  const ByteView parts = reader.rest();
  if (!reader.ok() || std::uint64_t{intrinsics_size} + depth_size > parts.size())
    return fail("a frame of depth ends within its parts");
  if (intrinsics_size > kMaxIntrinsics) return fail("intrinsics: are too long");
  const std::string_view intrinsics(reinterpret_cast<const char*>(parts.data()), intrinsics_size);
  const ByteView color_bytes = parts.subspan(std::size_t{intrinsics_size} + depth_size);

  const CameraIntrinsics parsed = TRY(at_place("intrinsics", parse_camera_intrinsics(intrinsics)));
  const std::uint64_t most = most_pixels(limits.max_points, limits.max_memory, kDepthMemory);
  const DepthPicture depth = TRY(at_place(
      "depth", with_advice(read_depth_picture(parts.subspan(intrinsics_size, depth_size), most),
                           most, limits.max_points)));
  const CameraIntrinsics camera = TRY(at_place("intrinsics", camera_of(parsed, depth)));
  if (parsed.distorts) notes.unread.emplace_back("distortion of the lens");
  std::optional<ColorPicture> color;
  if (!color_bytes.empty()) {
    const std::uint64_t left = limits.max_memory - depth.values.size() * kDepthMemory;
    const std::uint32_t max_points = DecodeLimits().max_points;
    const std::uint64_t most_colors = most_pixels(max_points, left, kColorMemory);
    color = TRY(at_place("color", with_advice(read_color_picture(color_bytes, most_colors),
                                              most_colors, max_points)));
    if (!same_shape(color->width, color->height, depth.width, depth.height)) {
      notes.unread.push_back(concat("colours of ", size_text(color->width, color->height),
                                    " pixels that do not lie over depth of ",
                                    size_text(depth.width, depth.height)));
      color.reset();
    }
  }
  return depth_points(depth, camera, color ? &*color : nullptr);
}

}  // namespace pointreel
