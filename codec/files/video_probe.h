#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "pointreel/error.h"

namespace pointreel {

/// A track of pictures in a video.
struct VideoTrack {
  int index = 0;  ///< among all tracks of the file
  std::string codec, pixels, title;
  std::uint32_t width = 0, height = 0;
  /// When each picture is shown, in microseconds from the beginning of the file; in order.
  std::vector<std::uint64_t> times_us;
  std::vector<bool> is_key;  ///< of each picture: it needs no other to be decoded
};

struct VideoProbe {
  std::vector<VideoTrack> tracks;  ///< those of pictures
  bool ends_early = false;         ///< cut off, as after a crash
};

/// The tracks of pictures in a Matroska file, by ffprobe, which reads the whole file but decodes
/// nothing. Errors do not contain the path: `not_found` if ffprobe is not installed; `invalid`,
/// `limit`, `io`. Trust: see depth_video.h.
Result<VideoProbe> probe_video(const std::filesystem::path& file);

/// For errors where ffmpeg or ffprobe is missing.
inline constexpr const char* kVideoNeedsFfmpeg =
    "ffmpeg is not installed, but videos need it: install it (apt-get install ffmpeg)";

}  // namespace pointreel
