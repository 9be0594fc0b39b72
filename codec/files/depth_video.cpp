#include "codec/files/depth_video.h"

#include <algorithm>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "codec/files/byte_source.h"
#include "codec/files/depth_capture.h"
#include "codec/files/depth_frame.h"
#include "codec/files/ply_header.h"
#include "codec/files/video_pictures.h"
#include "common/base/concat.h"
#include "common/base/out_of_memory.h"
#include "common/base/try.h"
#include "pointreel/codec.h"

namespace pointreel {
namespace fs = std::filesystem;
namespace {

using Kind = TrackPictures::Kind;

bool is_depth(const VideoTrack& track) { return track.pixels.starts_with("gray16"); }

/// The first track of that kind, or the first that is named so.
const VideoTrack* find_track(const std::vector<VideoTrack>& tracks, bool of_depth,
                             std::string_view title) {
  const VideoTrack* found = nullptr;
  for (const VideoTrack& track : tracks) {
    if (is_depth(track) != of_depth || track.times_us.empty()) continue;
    if (found == nullptr || (track.title == title && found->title != title)) found = &track;
  }
  return found;
}

tl::unexpected<Error> no_depth(const std::vector<VideoTrack>& tracks) {
  std::string list;
  for (const VideoTrack& track : tracks) {
    if (list.size() < 200)
      list += concat(list.empty() ? "; it has " : ", ", printable(track.codec), " in ",
                     printable(track.pixels));
  }
  return fail(ErrorCode::unsupported,
              concat("has no track of depth, which is grey of 16 bits (gray16le)", list));
}

Result<void> check_size(const VideoTrack& track) {
  const std::uint64_t most = DecodeLimits().max_points;
  const std::uint64_t pixels = std::uint64_t{track.width} * track.height;
  if (pixels > 0 && pixels <= most) return {};
  return fail(ErrorCode::limit, concat("has pictures of ", track.width, " x ", track.height,
                                       " pixels; at most ", most, " are accepted"));
}

class DepthVideo : public Recording {
 public:
  DepthVideo(std::string intrinsics, std::unique_ptr<TrackPictures> depth, bool ends_early)
      : intrinsics_(std::move(intrinsics)), depth_(std::move(depth)), ends_early_(ends_early) {}

  void add_colors(std::unique_ptr<TrackPictures> color) {
    matches_ = nearest_in_time(depth_->track().times_us, color->track().times_us);
    color_ = std::move(color);
  }

  CloudFormat format() const override { return CloudFormat::depth_frame; }
  std::size_t size() const override { return depth_->track().times_us.size(); }
  std::optional<std::uint64_t> time_ns(std::size_t frame) const override {
    return depth_->track().times_us[frame] * 1000;
  }
  RecordingLoss loss() const override {
    RecordingLoss loss;
    if (ends_early_)
      loss.warnings.push_back(concat("ends early, after ", size(),
                                     size() == 1 ? " frame" : " frames",
                                     ": what comes before is read"));
    return loss;
  }
  std::vector<std::string> guesses() const override { return guesses_of(intrinsics_); }
  std::string name(std::size_t frame) const override { return concat("picture ", frame); }

  Result<Bytes> read(std::size_t frame) const override {
    return or_out_of_memory([&]() -> Result<Bytes> {
      const auto depth = TRY(at_place("depth", depth_->read(frame)));
      if (color_ == nullptr) return depth_frame(intrinsics_, *depth, {});
      const auto color = TRY(at_place("color", color_->read(matches_[frame])));
      return depth_frame(intrinsics_, *depth, *color);
    });
  }

 private:
  const std::string intrinsics_;
  const std::unique_ptr<TrackPictures> depth_;
  const bool ends_early_;
  std::unique_ptr<TrackPictures> color_;
  std::vector<std::size_t> matches_;  ///< the picture of colours of each frame
};

}  // namespace

Result<std::shared_ptr<const Recording>> open_depth_video(const fs::path& file,
                                                          std::uint64_t max_memory) {
  std::error_code error;
  if (!fs::is_regular_file(file, error)) return fail("is not a file");
  const auto [tracks, ends_early] = TRY(probe_video(file));
  const VideoTrack* const depth = find_track(tracks, true, "DEPTH");
  if (depth == nullptr) return no_depth(tracks);
  TRY(check_size(*depth));
  std::vector<fs::path> beside = intrinsics_in(file.parent_path());
  beside.insert(beside.begin(), fs::path(file).replace_extension(".json"));
  std::string intrinsics = TRY(find_intrinsics(beside));
  auto video = std::make_shared<DepthVideo>(
      std::move(intrinsics),
      std::make_unique<TrackPictures>(file, *depth, Kind::depth, max_memory / 2), ends_early);
  if (const VideoTrack* const color = find_track(tracks, false, "COLOR")) {
    TRY(check_size(*color));
    video->add_colors(std::make_unique<TrackPictures>(file, *color, Kind::color, max_memory / 2));
  }
  return video;
}

}  // namespace pointreel
