#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/stream/live.h"
#include "pointreel/error.h"
#include "pointreel/package.h"

namespace pointreel {

/// Consecutive frames of a live stream, as they stand in a package.
struct LiveSegment {
  /// first_frame and times_us are the session's: its count of frames, and Unix time. Files have no
  /// names yet, but sizes and checksums.
  Segment entry;
  std::vector<Bytes> files;  ///< one for each layer
  std::uint32_t depth_min = 0, depth_max = 0;
  bool any_point = false;
  bool partial = false;  ///< Manifest::partial
};

/// Makes segments of the layers of a live stream, without decoding them. A frame that no package
/// may hold, whatever a publisher sends, is left out.
class Segmenter {
 public:
  /// A segment ends once it is so long, or has so many bytes.
  explicit Segmenter(std::uint64_t segment_us, std::uint64_t segment_bytes = 32u << 20)
      : segment_us_(segment_us), segment_bytes_(segment_bytes) {}

  /// What the layers are of, from the next frame on. With another session frames are counted from
  /// 0 again; flush first.
  void begin(const LiveHello& hello);

  /// A segment, if the frame that this layer begins ends one.
  std::optional<LiveSegment> add(const LiveLayer& layer);

  /// What there is, up to the last frame as far as it came.
  std::optional<LiveSegment> flush();

 private:
  bool begin_frame(const LiveLayer& layer);
  void end_frame();

  const std::uint64_t segment_us_, segment_bytes_;
  LiveHello hello_;
  LiveSegment segment_;
  Box cubes_;  ///< that frames have
  std::uint64_t bytes_ = 0;
  std::uint32_t frames_ = 0;  ///< of the session
  std::uint64_t last_us_ = 0;
  std::optional<std::uint32_t> frame_;  ///< whose layers are taken now
  std::uint8_t next_layer_ = 0;
  std::uint8_t promised_layers_ = 0;  ///< by its header
};

/// The names of a segment's files: 00000030.base.511922c5.prs, the count of its first frame, the
/// layer, and the first half of the checksum.
void name_files(LiveSegment& segment, const std::vector<std::string>& layers);

/// What a manifest says of all its segments together.
struct LiveTotals {
  std::uint32_t depth_min = 0, depth_max = 0;
  bool any_frame = false, any_point = false, partial = false;
  Box cubes;

  void add(const LiveSegment& segment);
};

/// All of a manifest but its segments, its duration and what makes it live.
Manifest live_head(const LiveHello& hello, const LiveTotals& totals);

/// The segment as it stands in a manifest whose first frame and time are these.
Segment rebased(Segment segment, std::uint32_t first_frame, std::uint64_t start_us);

/// When a segment that stands in a manifest ends, its last frame's own time included.
std::uint64_t end_of(const Segment& segment, double fps);

/// Whether segments made under both may stand in one manifest.
bool go_together(const LiveHello& a, const LiveHello& b);

}  // namespace pointreel
