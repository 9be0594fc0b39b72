#include "client/record/open_recorder.h"

#include <cctype>
#include <filesystem>
#include <utility>

#include "client/record/picture_sequence.h"
#include "client/record/video_writer.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

Result<NumberedPath> numbered(const std::string& path) {
  auto parsed = NumberedPath::parse(path);
  if (parsed) return parsed;
  return fail(
      ErrorCode::argument,
      "\"" + path +
          "\" is neither a video (.mp4, .mkv, .webm) nor contains exactly one place for the "
          "number of the picture, such as %04d in out-%04d.png");
}

}  // namespace

Result<void> check_picture_name(const std::string& path) {
  std::string ending = std::filesystem::path(path).extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (ending == ".png") return {};
  return fail(ErrorCode::argument,
              "\"" + path + "\" does not end in .png; pictures are written as PNG");
}

Result<void> check_recording_name(const std::string& path) {
  if (is_video(path)) return {};
  TRY(numbered(path));
  return check_picture_name(path);
}

Result<void> check_recording(const std::string& path) {
  return is_video(path) ? find_ffmpeg() : check_recording_name(path);
}

Result<std::unique_ptr<Recorder>> open_recorder(const std::string& path, glm::ivec2 size,
                                                const std::optional<FrameRate>& rate,
                                                std::optional<RecordedSound> sound) {
  if (is_video(path)) return TRY(VideoWriter::create(path, size, rate, std::move(sound)));
  return std::make_unique<PictureSequence>(TRY(numbered(path)));
}

}  // namespace pointreel
