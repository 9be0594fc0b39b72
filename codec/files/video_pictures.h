#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "codec/files/video_probe.h"
#include "common/process/ffmpeg_output.h"
#include "pointreel/bytes.h"
#include "pointreel/error.h"

namespace pointreel {

/// The pictures of one track of a video, decoded by ffmpeg, as PGM or PPM (picture.h). Those that
/// were decoded last are kept, and ffmpeg goes on from there, so that asking in order is fast. May
/// be used by several threads at once. Damaged pictures of depth are errors, and so may be some
/// near them; damaged colours may be left out, and those after them then come too early. Trust: see
/// depth_video.h.
class TrackPictures {
 public:
  enum class Kind : std::uint8_t { depth, color };

  TrackPictures(std::filesystem::path file, VideoTrack track, Kind kind, std::uint64_t max_memory);

  const VideoTrack& track() const { return track_; }
  /// Errors do not contain the path.
  Result<std::shared_ptr<const Bytes>> read(std::size_t picture);

 private:
  using Picture = std::shared_ptr<const Bytes>;
  /// ffmpeg at some place of the track.
  struct Decoder {
    std::optional<FfmpegOutput> output;
    std::size_t first = 0, next = 0;  ///< the picture that came first; the one that comes next
    std::uint64_t asked = 0;          ///< when it was last used, by count
  };

  Result<Decoder*> decoder_for(std::size_t picture);
  Result<void> start(Decoder& decoder, std::size_t at) const;
  Result<Picture> decode_next(Decoder& decoder);
  void keep(std::size_t number, Picture picture);

  const std::filesystem::path file_;
  const VideoTrack track_;
  const Kind kind_;
  const std::size_t most_kept_;
  std::mutex mutex_;  // guards what follows
  std::vector<std::unique_ptr<Decoder>> decoders_;
  std::vector<std::pair<std::size_t, Picture>> kept_;
  std::size_t oldest_ = 0;  ///< of those kept, once there are as many as may be
  std::uint64_t asked_ = 0;
};

}  // namespace pointreel
