#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <vector>

#include "pointreel/bytes.h"
#include "pointreel/cloud.h"
#include "pointreel/error.h"

namespace pointreel {

/// A frame as it stands in a recording: a chunk of its own, so that readers seek to any.
struct RecordedFrame {
  std::uint64_t time_ns = 0;
  std::uint64_t unpacked = 0;  ///< bytes of the chunk's records before zstd
  std::uint32_t checksum = 0;  ///< CRC-32 of these
  Bytes packed;
};

/// One message `sensor_msgs/msg/PointCloud2` of ROS 2 in CDR, on `/points` and in the frame `map`,
/// in world coordinates, with the columns of point_records.h. The axes stay as they are. May be
/// called from several threads. Error `limit`: the message takes more than 1 GiB.
Result<RecordedFrame> record_frame(const PointCloud& cloud, std::uint64_t time_us);

/// Writes an MCAP recording of frames, with an index of messages and a summary. Source: "MCAP
/// Format Specification", version 0 (mcap.dev/spec).
///
/// Memory: about 100 bytes for each frame. The errors begin with the path.
class RecordingWriter {
 public:
  explicit RecordingWriter(std::filesystem::path path);

  /// Adds the next frame, in the order of time.
  Result<void> add(const RecordedFrame& frame);
  Result<void> finish();

 private:
  /// Of a chunk and the index behind it.
  struct Place {
    std::uint64_t time_ns = 0, begin = 0, bytes = 0, index_bytes = 0, packed = 0, unpacked = 0;
  };

  Result<void> append(const Bytes& bytes);
  Bytes summary() const;

  std::filesystem::path path_;
  std::ofstream file_;
  std::uint64_t size_ = 0;
  std::vector<Place> places_;
};

}  // namespace pointreel
