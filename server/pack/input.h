#pragma once

#include <atomic>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <stop_token>
#include <vector>

#include "codec/cloud_file.h"
#include "common/base/error.h"
#include "common/cloud/geometry.h"

namespace pointreel {

/// The source files of one segment. They are read once to find what box holds them all and once to
/// be encoded; clouds are kept from the first time to the second as long as they fit a budget, so
/// that memory does not grow with the length of a segment.
class SegmentInput {
 public:
  explicit SegmentInput(std::span<const std::filesystem::path> files)
      : files_(files), kept_(files.size()) {}

  /// Reads all frames, as many at once as the calling arena has threads.
  Result<Box> read_bounds(const std::stop_token& stop);

  /// The cloud of a frame. Each frame is taken once; different frames from any thread.
  Result<LoadedCloud> take(std::size_t frame);

 private:
  std::span<const std::filesystem::path> files_;
  std::vector<std::unique_ptr<LoadedCloud>> kept_;
};

}  // namespace pointreel
