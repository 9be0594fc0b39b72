#include "codec/files/video_probe.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <utility>

#include "codec/files/ply_header.h"
#include "common/base/concat.h"
#include "common/base/parse_number.h"
#include "common/base/try.h"
#include "common/process/ffprobe.h"

namespace pointreel {
namespace {

constexpr std::size_t kMostPictures = std::size_t{1} << 20;
constexpr double kMostSeconds = 31.0 * 24 * 3600;

/// Microseconds.
Result<std::int64_t> time_of(std::string_view seconds) {
  double value = 0.0;
  if (!parse_number(seconds, value) || !(std::abs(value) <= kMostSeconds))
    return fail("has a picture without a time, or at one that cannot be");
  return std::llround(1e6 * value);
}

}  // namespace

Result<VideoProbe> probe_video(const std::filesystem::path& file) {
  VideoProbe probe;
  std::map<int, std::vector<std::pair<std::int64_t, bool>>> pictures;
  std::size_t count = 0;
  std::int64_t start = 0;
  const auto read = run_ffprobe(
      {"-protocol_whitelist", "file", "-f", "matroska", "-select_streams", "v", "-show_entries",
       "format=start_time:stream=index,codec_name,width,height,pix_fmt:stream_tags=title:"
       "packet=stream_index,pts_time,flags",
       "file:" + file.string()},
      [&](ProbeLine line) -> Result<void> {
        if (line.is("packet|")) {
          if (++count > kMostPictures) return fail(ErrorCode::limit, "has too many pictures");
          const bool is_key = line.value("flags").starts_with('K');
          pictures[line.number<int>("stream_index")].emplace_back(
              TRY(time_of(line.value("pts_time"))), is_key);
        } else if (line.is("stream|")) {
          VideoTrack track;
          track.index = line.number<int>("index");
          track.codec = line.value("codec_name");
          track.pixels = line.value("pix_fmt");
          track.title = line.value("tag:title");
          track.width = line.number<std::uint32_t>("width");
          track.height = line.number<std::uint32_t>("height");
          probe.tracks.push_back(std::move(track));
        } else if (line.is("format|")) {
          if (const auto time = time_of(line.value("start_time"))) start = *time;
        }
        return {};
      });
  if (!read) {
    const Error& why = read.error();
    if (why.code == ErrorCode::not_found) return fail(ErrorCode::not_found, kVideoNeedsFfmpeg);
    return fail(why.code, why.code == ErrorCode::invalid
                              ? concat("is not a readable Matroska video: ", printable(why.message))
                              : why.message);
  }
  // Said of Matroska's elements, of which the outermost has the length of the file.
  probe.ends_early = read->find("File ended prematurely") != std::string::npos;
  for (VideoTrack& track : probe.tracks) {
    auto& of_track = pictures[track.index];
    std::sort(of_track.begin(), of_track.end());
    for (const auto& [time, is_key] : of_track) {
      track.times_us.push_back(static_cast<std::uint64_t>(std::max<std::int64_t>(0, time - start)));
      track.is_key.push_back(is_key);
    }
  }
  return probe;
}

}  // namespace pointreel
