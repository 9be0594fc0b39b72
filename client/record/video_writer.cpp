#include "client/record/video_writer.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <initializer_list>
#include <map>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>

#include "client/record/matroska.h"
#include "common/base/try.h"
#include "common/base/words.h"
#include "common/file_system/write_file.h"
#include "common/process/ffmpeg.h"
#include "common/process/ffprobe.h"
#include "pointreel/package.h"

namespace pointreel {
namespace {

/// A track of a video that was written.
struct Track {
  bool is_video = false;
  std::uint64_t packets = 0;
  double end_s = 0.0;
};

/// ffmpeg's name for the container of a file; empty for other files.
std::string format_of(const std::string& path) {
  const std::string extension = std::filesystem::path(path).extension().string();
  if (extension == ".mp4") return "mp4";
  if (extension == ".mkv") return "matroska";
  return extension == ".webm" ? "webm" : "";
}

std::vector<std::string> arguments(const std::string& path, const std::string& part,
                                   const std::optional<FrameRate>& rate, bool sound) {
  const std::string format = format_of(path);
  std::vector<std::string> all;
  const auto add = [&](std::initializer_list<std::string> more) {
    all.insert(all.end(), more.begin(), more.end());
  };
  add({"-f", "matroska"});
  if (rate) add({"-r", fmt::format("{}/{}", rate->frames, rate->seconds)});
  add({"-i", "pipe:0"});
  if (sound) {
    add({"-probesize", "32", "-analyzeduration", "0"});  // there is nothing to find out
    add({"-f", "f32le", "-ar", fmt::format("{}", kAudioRate), "-ac", "2", "-i", "pipe:3"});
    add({"-map", "0:v", "-map", "1:a", "-c:a", format == "mp4" ? "aac" : "libopus", "-b:a"});
    add({format == "mp4" ? "192k" : "128k"});
  }
  add({"-fps_mode", "passthrough"});
  add({"-vf",
       "crop=trunc(iw/2)*2:trunc(ih/2)*2,"
       "scale=out_color_matrix=bt709:out_range=tv:flags=accurate_rnd+full_chroma_int,"
       "format=yuv420p"});
  if (format == "webm") {
    add({"-c:v", "libvpx-vp9", "-b:v", "0", "-crf", "24", "-row-mt", "1", "-deadline", "good",
         "-cpu-used", "4"});
  } else {
    add({"-c:v", "libx264", "-crf", "18"});
    // No B-frames for uneven times. With them, decoding times end before the last picture does,
    // and .mp4 takes its length from these.
    if (!rate) add({"-bf", "0"});
  }
  add({"-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "iec61966-2-1",
       "-color_range", "tv"});
  if (!rate) add({"-enc_time_base", "1:1000000"});
  if (format == "mp4") {
    add({"-movflags", "+faststart"});
    // Durations in .mp4 have 32 bits: in units of 10 us, a frame may stay for six hours.
    if (!rate) add({"-video_track_timescale", "100000"});
  }
  add({"-f", format, "-y", "file:" + part});
  return all;
}

tl::unexpected<Error> missing(const std::string& program) {
  return fail(ErrorCode::not_found,
              program +
                  " is not installed, but --record needs it for videos: install it (apt-get "
                  "install ffmpeg), or record pictures: --record out-%04d.png");
}

}  // namespace

bool is_video(const std::string& path) { return !format_of(path).empty(); }

Result<void> find_ffmpeg(const std::string& program) {
  for (const std::string& needed : {program, std::string("ffprobe")})
    if (!is_installed(needed)) return missing(needed);
  return {};
}

Result<std::unique_ptr<VideoWriter>> VideoWriter::create(const std::string& path, glm::ivec2 size,
                                                         const std::optional<FrameRate>& rate,
                                                         std::optional<RecordedSound> sound,
                                                         const std::string& program) {
  if (size.x < 2 || size.y < 2)
    return fail(ErrorCode::argument, fmt::format("{}: a video needs at least 2x2 pixels, not {}x{}",
                                                 path, size.x, size.y));
  std::unique_ptr<VideoWriter> writer(new VideoWriter(path));
  TRY(writer->start(size, rate, std::move(sound), program));
  return writer;
}

Result<void> VideoWriter::start(glm::ivec2 size, const std::optional<FrameRate>& rate,
                                std::optional<RecordedSound> sound, const std::string& program) {
  size_ = size;
  has_rate_ = rate.has_value();
  // Sockets and not pipes, because sending to them can be told not to raise SIGPIPE.
  const auto connected = [](std::array<int, 2>& ends) {
    return socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) == 0;
  };
  std::array<int, 2> ends{-1, -1}, sound_ends{-1, -1};
  const bool made = connected(ends) && (!sound || connected(sound_ends));
  const int error = errno;
  input_ = ends[0];
  if (sound_ends[0] >= 0) sound_.emplace(sound_ends[0], *std::move(sound));
  auto started = made ? Ffmpeg::start(arguments(path_, part(), rate, sound_.has_value()),
                                      {.input = ends[1], .second_input = sound_ends[1]}, program)
                      : fail(ErrorCode::io, fmt::format("{}: cannot be recorded: {}", path_,
                                                        std::strerror(error)));
  for (const int end : {ends[1], sound_ends[1]})
    if (end >= 0) close(end);
  if (!started && started.error().code == ErrorCode::not_found) return missing(program);
  ffmpeg_.emplace(TRY(std::move(started)));
  const std::string head =
      matroska_head(static_cast<std::uint32_t>(size.x), static_cast<std::uint32_t>(size.y));
  if (!send(head.data(), head.size())) return died();
  return {};
}

VideoWriter::~VideoWriter() {
  const bool unfinished = ffmpeg_ && input_ >= 0;
  if (unfinished) ffmpeg_->kill();
  wait();
  if (unfinished) std::remove(part().c_str());
}

Result<void> VideoWriter::add(const Image& picture, std::uint64_t time_us) {
  if (glm::ivec2(picture.width, picture.height) != size_)
    return fail(ErrorCode::argument,
                fmt::format("{}: a picture of {}x{} does not fit a video of {}x{}", path_,
                            picture.width, picture.height, size_.x, size_.y));
  if (last_time_us_) time_us = std::max(time_us, *last_time_us_ + 1);
  last_time_us_ = time_us;
  if (sound_) sound_->allow(time_us);
  if (!has_rate_) last_ = picture;
  return send(picture, time_us);
}

Result<void> VideoWriter::send(const Image& picture, std::uint64_t time_us) {
  const std::size_t bytes = picture.pixels.size() * sizeof(picture.pixels[0]);
  const std::string head = matroska_picture_head(time_us, bytes);
  if (!send(head.data(), head.size()) || !send(picture.pixels.data(), bytes)) return died();
  ++pictures_;
  return {};
}

Result<void> VideoWriter::finish(std::uint64_t end_us) {
  // ffmpeg knows when pictures begin, and not when the last one ends.
  if (!has_rate_ && last_time_us_ && end_us >= *last_time_us_ + 2 * kPictureUs)
    TRY(send(last_, end_us - kPictureUs));
  // ffmpeg may read the last pictures before the sound.
  if (input_ >= 0) close(std::exchange(input_, -1));
  if (const auto sounded = sound_ ? sound_->finish(end_us) : Result<void>(); !sounded) {
    ffmpeg_->kill();
    wait();
    std::remove(part().c_str());
    return fail_at(path_ + ": was not recorded: sound", sounded.error());
  }
  if (!wait()) return died();
  if (const Result<void> whole = check(end_us); !whole) {
    std::remove(part().c_str());
    return tl::unexpected(whole.error());
  }
  if (std::rename(part().c_str(), path_.c_str()) == 0) return {};
  const int error = errno;
  std::remove(part().c_str());
  return fail(ErrorCode::io,
              fmt::format("{}: cannot be written: {}", path_, why_not_written(error)));
}

Result<void> VideoWriter::check(std::uint64_t end_us) const {
  // A disk, above all a distant one, may be found to be full only now.
  const int file = open(part().c_str(), O_RDONLY | O_CLOEXEC);
  const bool stored = file >= 0 && fsync(file) == 0;
  const int error = errno;
  if (file >= 0) close(file);
  if (!stored) return failed(why_not_written(error));
  std::map<int, Track> tracks;
  std::string duration;
  const auto probed = run_ffprobe(
      {"-protocol_whitelist", "file", "-show_entries",
       "packet=stream_index,pts_time,duration_time:stream=index,codec_type:format=duration",
       "file:" + part()},
      [&](ProbeLine line) -> Result<void> {
        if (line.is("packet|")) {
          Track& track = tracks[line.number<int>("stream_index")];
          ++track.packets;
          track.end_s = std::max(
              track.end_s, line.number<double>("pts_time") + line.number<double>("duration_time"));
        } else if (line.is("stream|")) {
          tracks[line.number<int>("index")].is_video = line.value("codec_type") == "video";
        } else if (line.is("format|")) {
          duration = line.value("duration");
        }
        return {};
      });
  if (!probed) return failed(probed.error().message);
  const Track none;
  const auto track = [&](bool is_video) -> const Track& {
    const auto found = std::find_if(tracks.begin(), tracks.end(), [&](const auto& each) {
      return each.second.is_video == is_video;
    });
    return found == tracks.end() ? none : found->second;
  };
  if (const std::uint64_t got = track(true).packets; got != pictures_)
    return failed(fmt::format("{} of {} are in the file", got, counted(pictures_, "picture")));
  constexpr double kSoundFrame = 0.03;
  const double end_s = 1e-6 * static_cast<double>(end_us);
  if (sound_ && track(false).end_s + kSoundFrame < end_s)
    return failed(
        fmt::format("{:.2f} of {:.2f} s of sound are in the file", track(false).end_s, end_s));
  // ffmpeg writes the duration at the end.
  if (duration.empty() || duration == "N/A") return failed("the file has no end");
  return {};
}

tl::unexpected<Error> VideoWriter::failed(const std::string& why) const {
  const std::string said = ffmpeg_->reason();
  return fail(ErrorCode::io, fmt::format("{}: was not recorded: {}", path_,
                                         said.empty() ? why : said + "; " + why));
}

bool VideoWriter::send(const void* bytes, std::size_t size) const {
  const char* at = static_cast<const char*>(bytes);
  while (size > 0) {
    const ssize_t sent = ::send(input_, at, size, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return false;
    at += sent;
    size -= static_cast<std::size_t>(sent);
  }
  return true;
}

bool VideoWriter::wait() {
  if (input_ >= 0) close(std::exchange(input_, -1));
  return !ffmpeg_ || ffmpeg_->wait();
}

tl::unexpected<Error> VideoWriter::died() {
  wait();
  std::remove(part().c_str());
  const std::string why = ffmpeg_->reason();
  return fail(ErrorCode::io, fmt::format("{}: was not recorded: ffmpeg ended{}{}", path_,
                                         why.empty() ? "" : ": ", why));
}

}  // namespace pointreel
