#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "codec/live/live.h"
#include "codec/octree/frame_header.h"
#include "pointreel/error.h"
#include "pointreel/package.h"

namespace pointreel {

/// What the cube fills.
inline Box box_of(const Cube& cube) { return {cube.origin, cube.origin + cube.edge}; }

/// Consecutive frames of a live stream, as they stand in a package.
struct LiveSegment {
  /// Counts frames from the beginning of the session, and its times are those of capture. Its files
  /// have sizes and checksums, but no names yet.
  Segment entry;
  std::vector<std::string> files;  ///< the bytes of each layer's file
  Box cubes;                       ///< bounds of the cubes of all frames
  std::uint32_t depth_min = 0, depth_max = 0;
  bool any_point = false;
  bool partial = false;  ///< as Manifest::partial
};

/// Makes segments from the layers of a live stream, without decoding them. Frames that may not be
/// part of a package are left out.
class Segmenter {
 public:
  /// A segment ends when it reaches this duration, this size or kMaxFrames, so that any number of
  /// tiny frames in no time leaves the manifest short; or when the cube that would contain those of
  /// all its frames is too large.
  explicit Segmenter(std::uint64_t segment_us, std::uint64_t segment_bytes = 32u << 20)
      : segment_us_(segment_us), segment_bytes_(segment_bytes) {}

  static constexpr std::size_t kMaxFrames = 1000;

  /// Sets what describes the stream from the next frame on. With another session frames are counted
  /// from 0 again. Call flush before.
  void begin(const LiveHello& hello);

  /// Adds a layer. Returns the segment before it, if the layer begins the first frame of another.
  std::optional<LiveSegment> add(const LiveLayer& layer);

  /// Ends the present segment and returns it, if it has a frame. Its last frame may be partial.
  std::optional<LiveSegment> flush();

 private:
  bool ends_before(const LiveLayer& layer, const FrameHeader& header) const;
  void begin_frame(const LiveLayer& layer, const FrameHeader& header);
  void end_frame();
  std::uint64_t time_of(const LiveLayer& layer) const;

  const std::uint64_t segment_us_, segment_bytes_;
  LiveHello hello_;
  LiveSegment segment_;
  std::uint64_t bytes_ = 0;
  std::uint32_t frames_ = 0;            ///< in the session so far
  std::uint64_t last_us_ = 0;           ///< the time of the newest frame
  std::uint64_t shift_us_ = 0;          ///< from capture times to the times of frames
  std::optional<std::uint32_t> frame_;  ///< the frame whose layers are being added
  std::uint8_t next_layer_ = 0;
  std::uint8_t expected_layers_ = 0;  ///< layers of that frame, by its header
};

/// Names a segment's files, by layer_file_name.
void name_files(LiveSegment& segment, const std::vector<std::string>& layers);

/// What a manifest says about all its segments together.
struct LiveTotals {
  std::uint32_t depth_min = 0, depth_max = 0;
  bool any_frame = false, any_point = false, partial = false;
  Box cubes;

  void add(const LiveSegment& segment);
};

/// A manifest without its segments, its duration and `live`.
Manifest live_head(const LiveHello& hello, const LiveTotals& totals);

/// The segment's entry in a manifest that begins with this frame at this time.
Segment rebased(Segment segment, std::uint32_t first_frame, std::uint64_t start_us);

/// When a segment of a manifest ends, including the duration of its last frame.
std::uint64_t end_of(const Segment& segment, double fps);

/// Whether segments of streams with these hellos may be in one manifest.
bool go_together(const LiveHello& a, const LiveHello& b);

}  // namespace pointreel
