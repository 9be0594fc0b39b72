#include "client/record/open_recorder.h"

#include "client/record/picture_sequence.h"
#include "client/record/video_writer.h"

namespace pointreel {
namespace {

Result<NumberedPath> numbered(const std::string& path) {
  auto parsed = NumberedPath::parse(path);
  if (parsed) return parsed;
  return fail("\"" + path +
              "\" is neither a video (.mp4, .mkv, .webm) nor has exactly one place for a picture's "
              "number, such as out-%04d.png");
}

}  // namespace

Result<void> check_recording_name(const std::string& path) {
  if (is_video(path)) return {};
  if (const auto parsed = numbered(path); !parsed) return tl::unexpected(parsed.error());
  return {};
}

Result<void> check_recording(const std::string& path) {
  return is_video(path) ? find_ffmpeg() : check_recording_name(path);
}

Result<std::unique_ptr<Recorder>> open_recorder(const std::string& path, glm::ivec2 size,
                                                const std::optional<FrameRate>& rate) {
  if (is_video(path)) {
    auto video = VideoWriter::create(path, size, rate);
    if (!video) return tl::unexpected(video.error());
    return *std::move(video);
  }
  auto files = numbered(path);
  if (!files) return tl::unexpected(files.error());
  return std::make_unique<PictureSequence>(*std::move(files));
}

}  // namespace pointreel
