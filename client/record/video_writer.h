#pragma once

#include <memory>
#include <optional>
#include <string>

#include <glm/glm.hpp>

#include "client/record/audio_feed.h"
#include "client/record/frame_rate.h"
#include "client/record/recorder.h"
#include "common/process/ffmpeg.h"

namespace pointreel {

/// Whether the name ends with .mp4, .mkv or .webm.
bool is_video(const std::string& path);

/// Fails with ErrorCode::not_found if ffmpeg, or the ffprobe that comes with it, is not installed.
Result<void> find_ffmpeg(const std::string& program = "ffmpeg");

/// Lets ffmpeg write a video: H.264 at a quality that looks lossless, or VP9 in .webm. Colours are
/// BT.709 with 8 bits and 4:2:0, which needs an even size: an odd row or column at the edge is cut
/// off. With a rate, each picture lasts exactly as long as the rate says, and times are ignored.
/// Without a rate, pictures begin at their times, with the resolution of the container:
/// microseconds in .mp4, else milliseconds. The last picture comes a second time shortly before its
/// end, from which ffmpeg knows when that is.
///
/// Sound begins with the first picture and ends with the last one, to the sample; it is AAC in
/// .mp4, which ends in up to 21 ms of silence more, and Opus elsewhere.
///
/// Until the video is finished, its file has the additional extension .part. It gets its name once
/// ffprobe has found all pictures and the whole sound in it: on a full disk, ffmpeg goes on and
/// ends well. ffmpeg runs in a process group of its own, so that a Ctrl+C for the player does not
/// cut off the recording.
class VideoWriter : public Recorder {
 public:
  /// Starts ffmpeg for pictures of this size, at least 2x2. `program` is found as by a shell. Fails
  /// with ErrorCode::argument for smaller pictures, ErrorCode::not_found without ffmpeg, and
  /// ErrorCode::io if it ends.
  static Result<std::unique_ptr<VideoWriter>> create(const std::string& path, glm::ivec2 size,
                                                     const std::optional<FrameRate>& rate,
                                                     std::optional<RecordedSound> sound = {},
                                                     const std::string& program = "ffmpeg");
  /// Removes a video that is not finished.
  ~VideoWriter() override;
  VideoWriter(const VideoWriter&) = delete;
  VideoWriter& operator=(const VideoWriter&) = delete;

  Result<void> add(const Image& picture, std::uint64_t time_us) override;
  Result<void> finish(std::uint64_t end_us) override;

 private:
  explicit VideoWriter(std::string path) : path_(std::move(path)) {}

  std::string part() const { return path_ + ".part"; }
  Result<void> start(glm::ivec2 size, const std::optional<FrameRate>& rate,
                     std::optional<RecordedSound> sound, const std::string& program);
  /// Returns false if ffmpeg has ended.
  bool send(const void* bytes, std::size_t size) const;
  Result<void> send(const Image& picture, std::uint64_t time_us);
  /// Lets ffmpeg end, and says whether it says that all went well.
  bool wait();
  /// Whether the file is whole. `end_us`: when the sound ends.
  Result<void> check(std::uint64_t end_us) const;
  tl::unexpected<Error> failed(const std::string& why) const;
  tl::unexpected<Error> died();

  const std::string path_;
  glm::ivec2 size_{0};
  int input_ = -1;  ///< a socket to ffmpeg's standard input
  std::optional<Ffmpeg> ffmpeg_;
  std::optional<AudioFeed> sound_;
  bool has_rate_ = false;
  std::uint64_t pictures_ = 0;
  std::optional<std::uint64_t> last_time_us_;
  Image last_;  ///< without a rate
};

}  // namespace pointreel
