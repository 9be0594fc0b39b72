#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "codec/files/byte_source.h"
#include "codec/files/recording.h"
#include "pointreel/bytes.h"
#include "pointreel/error.h"

namespace pointreel {

/// The messages of one topic of an MCAP recording, as ROS 2 writes them: those that
/// point_cloud2.h reads. Chunks may be compressed by zstd or lz4. Messages are in the order of the
/// times at which they were recorded. Opening reads the indexes, or, where there are none, the
/// chunks; a message is read when it is asked for. May be used by several threads at once.
/// Source: "MCAP Format Specification", version 0 (mcap.dev/spec).
///
/// Trust: the bytes may be hostile. Memory is bounded by a constant times their number, and by the
/// chunks that are kept, which are no larger than `max_memory` together.
class McapRecording : public Recording {
 public:
  /// An empty `topic` stands for the only one of point clouds. Errors do not contain the path:
  /// `argument` if there are several or none of that name, which the message lists; `unsupported`
  /// for other kinds of messages; `invalid`, `limit`. What ends early, as after a crash, is read up
  /// to there, even within a chunk, and `loss` says where it ends. With `best_effort`, damaged
  /// parts are left out, which `loss` says as well.
  static Result<std::shared_ptr<const McapRecording>> open(ByteSource source,
                                                           const std::string& topic,
                                                           std::uint64_t max_memory,
                                                           bool best_effort = false);
  ~McapRecording() override;

  CloudFormat format() const override { return CloudFormat::point_cloud2; }
  std::size_t size() const override;
  /// Of every message, since 1970.
  std::optional<std::uint64_t> time_ns(std::size_t message) const override;
  RecordingLoss loss() const override;
  std::string name(std::size_t message) const override;
  Result<Bytes> read(std::size_t message) const override;

 private:
  class Impl;
  explicit McapRecording(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace pointreel
