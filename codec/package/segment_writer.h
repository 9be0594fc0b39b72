#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "codec/package/layer_writer.h"
#include "pointreel/codec.h"
#include "pointreel/error.h"
#include "pointreel/geometry.h"
#include "pointreel/package.h"

namespace pointreel {

/// Writes the layer files of a segment, frame after frame, and collects its entry in the manifest.
class SegmentWriter {
 public:
  /// `first_frame`: the number of its first frame in the reel. `layer_names`:
  /// ReelHead::layer_names.
  SegmentWriter(const std::filesystem::path& folder, std::uint32_t first_frame,
                const std::vector<std::string>& layer_names);

  /// `time_us`: when the frame is shown, from the reel's start.
  Result<void> append(const EncodedFrame& frame, std::uint64_t time_us);

  /// The finished entry, with Segment::cube as given; an error if anything could not be written.
  Result<Segment> finish(const Cube& cube);

 private:
  std::vector<LayerWriter> files_;
  Segment entry_;
};

/// The time of a frame of a sequence whose frames all last equally long.
std::uint64_t presentation_time_us(std::size_t frame, double fps);

}  // namespace pointreel
