#include "codec/files/depth_capture.h"

#include <algorithm>
#include <system_error>

#include "codec/files/byte_source.h"
#include "codec/files/camera_intrinsics.h"
#include "common/base/concat.h"
#include "common/base/try.h"

namespace pointreel {
namespace fs = std::filesystem;
namespace {

Result<std::string> read_intrinsics(const fs::path& file) {
  const ByteSource source = TRY(ByteSource::open(file));
  if (source.size() > kMaxIntrinsics) {
    return fail(ErrorCode::limit,
                concat("has ", source.size(), " bytes; intrinsics have at most ", kMaxIntrinsics));
  }
  Bytes room;
  const ByteView bytes = TRY(source.all(room));
  std::string text(bytes.begin(), bytes.end());
  TRY(parse_camera_intrinsics(text));
  return text;
}

}  // namespace

Result<std::string> find_intrinsics(const std::vector<fs::path>& files) {
  std::error_code ignored;
  for (const fs::path& file : files)
    if (fs::exists(file, ignored)) return at_place(file.string(), read_intrinsics(file));
  return fail(
      ErrorCode::not_found,
      concat(files.front().string(),
             ": is missing: it says fx, fy, cx and cy of the camera of depth, in pixels, and "
             "depth_scale, the steps per metre (1000 without it)"));
}

std::vector<std::string> guesses_of(std::string_view intrinsics) {
  const auto camera = parse_camera_intrinsics(intrinsics);
  if (!camera || camera->scale_is_given) return {};
  return {concat("depth of ", camera->steps_per_meter,
                 " steps per metre (depth_scale in the intrinsics changes it)")};
}

std::vector<fs::path> intrinsics_in(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const char* name : {"intrinsic.json", "intrinsics.json", "camera_intrinsic.json",
                           "camera_intrinsics.json", "camera.json"})
    files.push_back(folder / name);
  return files;
}

std::vector<std::size_t> nearest_in_time(const std::vector<std::uint64_t>& times,
                                         const std::vector<std::uint64_t>& others) {
  std::vector<std::size_t> nearest;
  nearest.reserve(times.size());
  for (const std::uint64_t time : times) {
    auto after = std::lower_bound(others.begin(), others.end(), time);
    if (after == others.end()) --after;
    if (after != others.begin() && *after > time && time - *(after - 1) < *after - time) --after;
    nearest.push_back(static_cast<std::size_t>(after - others.begin()));
  }
  return nearest;
}

}  // namespace pointreel
