#pragma once

#include <atomic>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <stop_token>
#include <vector>

#include "codec/cloud_file.h"
#include "pointreel/error.h"
#include "pointreel/geometry.h"

namespace pointreel {

/// The source files of one segment. They are read once to find what box holds them all, perhaps to
/// be looked at, and once to be encoded; clouds are kept from the first time to the second as long
/// as they fit a budget, so that memory does not grow with the length of a segment.
class SegmentInput {
 public:
  explicit SegmentInput(std::span<const std::filesystem::path> files)
      : files_(files), kept_(files.size()) {}

  /// Reads all frames, as many at once as the calling arena has threads.
  Result<Box> read_bounds(const std::stop_token& stop);

  using Cloud = std::shared_ptr<const LoadedCloud>;

  /// The cloud of a frame; it stays. From any thread.
  Result<Cloud> look(std::size_t frame) const;
  /// Likewise, but it goes: to take it again is to read it again. Different frames from any thread.
  Result<Cloud> take(std::size_t frame);

 private:
  std::span<const std::filesystem::path> files_;
  std::vector<Cloud> kept_;
};

}  // namespace pointreel
