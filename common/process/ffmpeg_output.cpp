#include "common/process/ffmpeg_output.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

namespace pointreel {
namespace {

constexpr int kPatience = 30'000;  // milliseconds

}  // namespace

Result<FfmpegOutput> FfmpegOutput::start(const std::vector<std::string>& arguments,
                                         const std::string& program) {
  std::array<int, 2> ends{-1, -1};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) return fail(ErrorCode::io, std::strerror(errno));
  Result<Ffmpeg> ffmpeg = Ffmpeg::start(arguments, {.output = ends[1]}, program);
  ::close(ends[1]);
  if (ffmpeg) return FfmpegOutput(std::move(*ffmpeg), ends[0]);
  ::close(ends[0]);
  return tl::unexpected(ffmpeg.error());
}

FfmpegOutput::FfmpegOutput(FfmpegOutput&& other) noexcept
    : ffmpeg_(std::move(other.ffmpeg_)), pipe_(std::exchange(other.pipe_, -1)) {}

FfmpegOutput::~FfmpegOutput() {
  if (pipe_ >= 0) ::close(pipe_);
}

Result<std::size_t> FfmpegOutput::read(std::span<std::uint8_t> bytes) {
  std::size_t got = 0;
  while (got < bytes.size()) {
    pollfd ready{pipe_, POLLIN, 0};
    const int polled = ::poll(&ready, 1, kPatience);
    if (polled < 0 && errno == EINTR) continue;
    if (polled == 0) return fail(ErrorCode::io, "ffmpeg has not written anything for 30 seconds");
    const ssize_t size = ::read(pipe_, bytes.data() + got, bytes.size() - got);
    if (size < 0 && errno == EINTR) continue;
    if (size < 0) return fail(ErrorCode::io, std::strerror(errno));
    if (size == 0) break;
    got += static_cast<std::size_t>(size);
  }
  return got;
}

std::optional<std::string> FfmpegOutput::fault() {
  if (ffmpeg_.wait()) return std::nullopt;
  return ffmpeg_.reason();
}

}  // namespace pointreel
