#pragma once

#include <memory>
#include <optional>
#include <string>

#include <glm/glm.hpp>

#include "client/record/frame_rate.h"
#include "client/record/recorder.h"

namespace pointreel {

/// Whether the name ends as a video's: .mp4, .mkv or .webm.
bool is_video(const std::string& path);

/// Whether ffmpeg is there; the error says what to do.
Result<void> find_ffmpeg(const std::string& program = "ffmpeg");

/// A video, written by ffmpeg: H.264 at a quality that looks lossless, or VP9 in .webm; BT.709
/// colours of 8 bits, 4:2:0, and so of even size: an odd one loses its last row or column. With a
/// rate each picture lasts exactly as long as that says, and times given are not looked at; without
/// one, pictures begin at their times, to the container's microsecond (.mp4) or millisecond.
///
/// The file is there when it is finished: until then it is called so with .part behind it. ffmpeg
/// runs in a process group of its own: what interrupts the player does not cut the recording off.
class VideoWriter : public Recorder {
 public:
  /// Pictures will have this size, at least 2x2. `program`: found as a shell does.
  static Result<std::unique_ptr<VideoWriter>> create(const std::string& path, glm::ivec2 size,
                                                     const std::optional<FrameRate>& rate,
                                                     const std::string& program = "ffmpeg");
  /// What is not finished is removed.
  ~VideoWriter() override;
  VideoWriter(const VideoWriter&) = delete;
  VideoWriter& operator=(const VideoWriter&) = delete;

  Result<void> add(const Image& picture, std::uint64_t time_us) override;
  Result<void> finish() override;

 private:
  explicit VideoWriter(std::string path) : path_(std::move(path)) {}

  std::string part() const { return path_ + ".part"; }
  Result<void> start(glm::ivec2 size, const std::optional<FrameRate>& rate,
                     const std::string& program);
  /// False if ffmpeg reads no more.
  bool send(const void* bytes, std::size_t size) const;
  void wait();
  tl::unexpected<Error> died();

  const std::string path_;
  glm::ivec2 size_{0};
  int input_ = -1;     ///< a socket that is ffmpeg's standard input
  int messages_ = -1;  ///< a nameless file that is its standard error
  int process_ = -1;   ///< until it has been waited for
  int status_ = 0;     ///< waitpid's
  std::optional<std::uint64_t> last_time_us_;
};

}  // namespace pointreel
