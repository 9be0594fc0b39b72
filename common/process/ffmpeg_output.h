#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/process/ffmpeg.h"
#include "pointreel/error.h"

namespace pointreel {

/// What ffmpeg, or ffprobe, writes to its standard output. The program is ended with this object.
class FfmpegOutput {
 public:
  /// As Ffmpeg::start.
  static Result<FfmpegOutput> start(const std::vector<std::string>& arguments,
                                    const std::string& program);
  FfmpegOutput(FfmpegOutput&& other) noexcept;
  FfmpegOutput& operator=(FfmpegOutput&&) = delete;
  ~FfmpegOutput();

  /// Fills the bytes, and returns how many there were, which are fewer only at the end. Errors:
  /// `io` if nothing comes for half a minute.
  Result<std::size_t> read(std::span<std::uint8_t> bytes);
  /// As Ffmpeg::said.
  std::string said() const { return ffmpeg_.said(); }
  /// Nothing if all went well, once the end has been read; else why not, in one line.
  std::optional<std::string> fault();

 private:
  FfmpegOutput(Ffmpeg ffmpeg, int pipe) : ffmpeg_(std::move(ffmpeg)), pipe_(pipe) {}

  Ffmpeg ffmpeg_;
  int pipe_;
};

}  // namespace pointreel
