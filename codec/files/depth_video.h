#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "codec/files/recording.h"
#include "pointreel/error.h"

namespace pointreel {

/// Opens a video of depth in Matroska (.mkv): a track of grey of 16 bits (ffv1 or raw, as Azure
/// Kinect records it), and one of colours if there is one. Where several tracks would do, those
/// named DEPTH and COLOR are taken. Intrinsics are beside it: NAME.json, or as in a folder
/// (depth_capture.h). Each frame is a depth_frame with the colours that are nearest in time.
///
/// This needs ffmpeg and ffprobe. Opening reads the file once; pictures are decoded when they are
/// asked for, and fastest in their order. `max_memory` is for the pictures that are kept, of which
/// there is always one of each track.
///
/// Errors do not contain the path, unless they are about the intrinsics: `not_found` if ffmpeg or
/// the intrinsics are missing, `unsupported` if there is no track of depth, `invalid`, `limit`,
/// `io`.
///
/// Trust: the file may be hostile. ffmpeg reads it in a process of its own, as Matroska only and
/// without opening other files; it is as safe as the one that is installed. Its output is bounded:
/// 64 MiB about the file, and pictures of at most 2^26 pixels, which it must begin within 30
/// seconds.
Result<std::shared_ptr<const Recording>> open_depth_video(const std::filesystem::path& file,
                                                          std::uint64_t max_memory);

}  // namespace pointreel
