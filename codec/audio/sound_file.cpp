#include "codec/audio/sound_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <string_view>
#include <system_error>

#include <fmt/format.h>

#include "common/base/parse_number.h"
#include "common/base/try.h"
#include "common/base/words.h"
#include "common/process/ffprobe.h"

namespace pointreel {
namespace fs = std::filesystem;
namespace {

/// The names of ffmpeg's demuxers.
constexpr const char* kFormats =
    "aac,ac3,aiff,amr,amrnb,amrwb,ape,asf,asf_o,au,avi,caf,dsf,dts,dtshd,eac3,flac,flv,gsm,iff,"
    "ircam,ivf,live_flv,loas,m4a,matroska,mlp,mov,mp3,mpc,mpc8,mpeg,mpegts,mxf,nut,ogg,oma,qcp,rm,"
    "rso,shn,sox,tak,truehd,tta,voc,vqf,w64,wav,webm,wsaud,wtv,wv,xwma";

/// Beyond whole packets: encoders delay the sound, and decoders leave out what was padded.
constexpr double kSlack = 0.1;
/// How much longer than asked for a file is read: its tracks do not keep in step.
constexpr double kAhead = 1.0;
constexpr double kMostSeconds = 31.0 * 24 * 3600;

/// Nothing where ffprobe prints N/A, or a time that cannot be.
std::optional<double> seconds_in(std::string_view text) {
  double value = 0.0;
  if (!parse_number(text, value) || !(std::abs(value) <= kMostSeconds)) return std::nullopt;
  return value;
}

std::string seconds_text(double seconds) { return number_text(seconds, 4) + " s"; }

constexpr const char* kRepair =
    "; it is cut off or damaged: give a whole file, or take what is there (ffmpeg -i FILE -c copy "
    "NEW)";

struct Track {
  bool is_sound = false;
  double end = 0.0, longest = 0.0;  ///< seconds: of its packets
  std::optional<double> stated;     ///< seconds: how long the file says that it is
};

/// The size that a file of RIFF (WAV, AVI) states, which ffmpeg does not compare with the file; 0
/// if there is none. Programs that write to a pipe leave one that cannot be.
std::uint64_t stated_size(const fs::path& file) {
  constexpr std::uint32_t kUnknown = 0x7ffff000;
  std::array<unsigned char, 8> head{};
  std::ifstream in(file, std::ios::binary);
  if (!in.read(reinterpret_cast<char*>(head.data()), head.size())) return 0;
  if (std::string_view(reinterpret_cast<const char*>(head.data()), 4) != "RIFF") return 0;
  std::uint32_t size = 0;
  for (int i = 3; i >= 0; --i) size = size << 8 | head[static_cast<std::size_t>(4 + i)];
  return size >= kUnknown ? 0 : size + std::uint64_t{head.size()};
}

Result<void> check_size(const fs::path& file) {
  constexpr std::uint64_t kSloppy = 4096;  // some count a header too many
  std::error_code error;
  const std::uint64_t size = fs::file_size(file, error), stated = stated_size(file);
  if (error || size + kSloppy >= stated) return {};
  return fail(fmt::format("ends after {} of {} bytes{}", size, stated, kRepair));
}

}  // namespace

std::vector<std::string> sound_input(const fs::path& file) {
  return {"-protocol_whitelist",  "file", "-format_whitelist", kFormats, "-i",
          "file:" + file.string()};
}

Error unreadable_sound(const std::string& why) {
  if (why.find("Format not on whitelist") != std::string::npos)
    return {"is not a file of sound or video; playlists are not read, since they name other files"};
  if (why.find("matches no streams") != std::string::npos) return {"has no sound"};
  return {fmt::format("cannot be read as sound{}{}", why.empty() ? "" : ": ", why)};
}

Result<void> SoundEnd::check(std::uint64_t got_us, std::uint64_t wanted_us,
                             const std::string& why) const {
  const std::uint64_t expected_us = std::min(end_us, wanted_us);
  if (got_us + slack_us >= expected_us) return {};
  return fail(fmt::format("only {} of {} can be decoded{}{}{}",
                          seconds_text(1e-6 * static_cast<double>(got_us)),
                          seconds_text(1e-6 * static_cast<double>(expected_us)),
                          why.empty() ? "" : ": ", why, kRepair));
}

Result<SoundEnd> find_sound_end(const fs::path& file, std::optional<std::uint64_t> most_us) {
  const double most = most_us ? 1e-6 * static_cast<double>(*most_us) : kMostSeconds;
  std::map<int, Track> tracks;
  double start = 0.0, end = 0.0;
  std::optional<double> stated;
  // At this level it says that it guesses a duration.
  std::vector<std::string> arguments{"-loglevel", "warning"};
  if (most_us)
    arguments.insert(arguments.end(), {"-read_intervals", fmt::format("%+{}", most + kAhead)});
  arguments.insert(arguments.end(), {"-show_entries",
                                     "packet=stream_index,pts_time,dts_time,duration_time:stream="
                                     "index,codec_type,duration:format=start_time,duration"});
  const std::vector<std::string> input = sound_input(file);
  arguments.insert(arguments.end(), input.begin(), input.end());
  const auto probed = run_ffprobe(arguments, [&](ProbeLine line) -> Result<void> {
    if (line.is("packet|")) {
      Track& track = tracks[line.number<int>("stream_index")];
      auto time = seconds_in(line.value("pts_time"));
      if (!time) time = seconds_in(line.value("dts_time"));
      const double duration = seconds_in(line.value("duration_time")).value_or(0.0);
      track.end = std::max(track.end, time.value_or(track.end) + duration);
      track.longest = std::max(track.longest, duration);
      end = std::max(end, track.end);
    } else if (line.is("stream|")) {
      Track& track = tracks[line.number<int>("index")];
      track.is_sound = line.value("codec_type") == "audio";
      track.stated = seconds_in(line.value("duration"));
    } else if (line.is("format|")) {
      start = seconds_in(line.value("start_time")).value_or(0.0);
      stated = seconds_in(line.value("duration"));
    }
    return {};
  });
  if (!probed) {
    const Error& why = probed.error();
    if (why.code == ErrorCode::not_found) return fail(ErrorCode::not_found, kSoundNeedsFfmpeg);
    if (why.code != ErrorCode::invalid) return tl::unexpected(why);
    return tl::unexpected(unreadable_sound(why.message));
  }
  const auto sound = std::find_if(tracks.begin(), tracks.end(),
                                  [](const auto& track) { return track.second.is_sound; });
  if (sound == tracks.end()) return fail("has no sound");
  const double slack = kSlack + sound->second.longest;
  if (end + slack < most) TRY(check_size(file));
  const bool is_guess = probed->find("Estimating duration from bitrate") != std::string::npos;
  if (stated && !is_guess && end + slack < std::min(*stated, most)) {
    return fail(fmt::format("ends after {} of the {} that it states{}", seconds_text(end),
                            seconds_text(*stated), kRepair));
  }
  const auto us = [](double seconds) {
    return static_cast<std::uint64_t>(std::llround(1e6 * std::max(0.0, seconds)));
  };
  SoundEnd found{us(sound->second.end - std::max(0.0, start)), us(slack)};
  if (sound->second.end < most) {
    found.whole_us = found.end_us;
  } else if (const auto& length = sound->second.stated; length && !is_guess) {
    found.whole_us = std::max(found.end_us, us(*length));
  }
  return found;
}

}  // namespace pointreel
