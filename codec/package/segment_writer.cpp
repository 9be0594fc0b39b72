#include "codec/package/segment_writer.h"

#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "common/base/try.h"

namespace pointreel {

SegmentWriter::SegmentWriter(const std::filesystem::path& folder, std::uint32_t first_frame,
                             const std::vector<std::string>& layer_names) {
  entry_.first_frame = first_frame;
  for (const std::string& layer : layer_names) {
    files_.emplace_back(folder, fmt::format("{:05}.{}", first_frame, layer));
  }
}

Result<void> SegmentWriter::append(const EncodedFrame& frame, std::uint64_t time_us) {
  if (frame.layers.size() > files_.size()) return fail("the codec made too many layers");
  static const Chunks<Bytes> kNone;
  for (std::size_t i = 0; i < files_.size(); ++i) {
    files_[i].append(i < frame.layers.size() ? frame.layers[i] : kNone);
  }
  entry_.times_us.push_back(time_us);
  entry_.points.push_back(frame.source_points);
  return {};
}

Result<Segment> SegmentWriter::finish(const Cube& cube) {
  for (LayerWriter& file : files_) entry_.layers.push_back(TRY(file.finish()));
  entry_.cube = cube;
  return std::move(entry_);
}

std::uint64_t presentation_time_us(std::size_t frame, double fps) {
  return static_cast<std::uint64_t>(std::llround(static_cast<double>(frame) * 1e6 / fps));
}

}  // namespace pointreel
