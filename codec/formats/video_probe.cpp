#include "codec/formats/video_probe.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include "common/base/concat.h"
#include "common/base/ffmpeg_output.h"
#include "common/base/parse_number.h"
#include "common/base/try.h"
#include "common/cloud/ply_header.h"

namespace pointreel {
namespace {

/// Of what ffprobe says: about 50 bytes for each picture.
constexpr std::size_t kMaxText = std::size_t{64} << 20;
constexpr double kMostSeconds = 31.0 * 24 * 3600;

Result<std::string> run_ffprobe(const std::filesystem::path& file) {
  Result<FfmpegOutput> started = FfmpegOutput::start(
      {"-protocol_whitelist", "file", "-f", "matroska", "-select_streams", "v", "-show_entries",
       "format=start_time:stream=index,codec_name,width,height,pix_fmt:stream_tags=title:"
       "packet=stream_index,pts_time,flags",
       "-of", "compact", "file:" + file.string()},
      "ffprobe");
  if (!started && started.error().code == ErrorCode::not_found)
    return fail(ErrorCode::not_found, kVideoNeedsFfmpeg);
  FfmpegOutput output = TRY(std::move(started));
  std::string text;
  std::vector<std::uint8_t> block(1 << 16);
  for (;;) {
    const std::size_t got = TRY(output.read(block));
    text.append(block.begin(), block.begin() + static_cast<std::ptrdiff_t>(got));
    if (text.size() > kMaxText) return fail(ErrorCode::limit, "has too many pictures");
    if (got < block.size()) break;
  }
  if (const auto fault = output.fault())
    return fail(concat("is no video in Matroska that can be read: ", printable(*fault)));
  return text;
}

/// A line such as "stream|index=0|codec_name=ffv1".
class Line {
 public:
  explicit Line(std::string_view text) : text_(text) {}
  bool is(std::string_view kind) const { return text_.starts_with(kind); }
  std::string_view value(std::string_view key) const {
    for (std::size_t at = text_.find('|'); at != text_.npos; at = text_.find('|', at + 1)) {
      std::string_view field = text_.substr(at + 1);
      field = field.substr(0, field.find('|'));
      if (field.starts_with(key) && field.substr(key.size()).starts_with('='))
        return field.substr(key.size() + 1);
    }
    return {};
  }

 private:
  std::string_view text_;
};

template <class Number>
Number number_of(std::string_view text) {
  Number number{};
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

/// Microseconds.
Result<std::int64_t> time_of(std::string_view seconds) {
  double value = 0.0;
  if (!parse_number(seconds, value) || !(std::abs(value) <= kMostSeconds))
    return fail("has a picture without a time, or at one that cannot be");
  return std::llround(1e6 * value);
}

}  // namespace

Result<std::vector<VideoTrack>> probe_video(const std::filesystem::path& file) {
  const std::string text = TRY(run_ffprobe(file));
  std::vector<VideoTrack> tracks;
  std::map<int, std::vector<std::pair<std::int64_t, bool>>> pictures;
  std::int64_t start = 0;
  for (std::string_view rest = text; !rest.empty();) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    const Line line(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (line.is("packet|")) {
      const bool is_key = line.value("flags").starts_with('K');
      pictures[number_of<int>(line.value("stream_index"))].emplace_back(
          TRY(time_of(line.value("pts_time"))), is_key);
    } else if (line.is("stream|")) {
      VideoTrack track;
      track.index = number_of<int>(line.value("index"));
      track.codec = line.value("codec_name");
      track.pixels = line.value("pix_fmt");
      track.title = line.value("tag:title");
      track.width = number_of<std::uint32_t>(line.value("width"));
      track.height = number_of<std::uint32_t>(line.value("height"));
      tracks.push_back(std::move(track));
    } else if (line.is("format|")) {
      if (const auto time = time_of(line.value("start_time"))) start = *time;
    }
  }
  for (VideoTrack& track : tracks) {
    auto& of_track = pictures[track.index];
    std::sort(of_track.begin(), of_track.end());
    for (const auto& [time, is_key] : of_track) {
      track.times_us.push_back(static_cast<std::uint64_t>(std::max<std::int64_t>(0, time - start)));
      track.is_key.push_back(is_key);
    }
  }
  return tracks;
}

}  // namespace pointreel
