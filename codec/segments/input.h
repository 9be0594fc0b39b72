#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "codec/package/frames_grid.h"
#include "codec/package/grid.h"
#include "codec/segments/pack_options.h"
#include "codec/segments/source_frames.h"
#include "pointreel/error.h"

namespace pointreel {

/// The frames of one segment. With PackOptions::best_effort, a frame that cannot be read is
/// replaced by the nearest one before, or else after it, or by an empty one. If the frames share a
/// cube, the files are read once to find it, and once more to be encoded. Clouds are kept in memory
/// from the first time to the second as long as they fit a budget, so that memory does not grow
/// with the length of the segment.
class SegmentInput {
 public:
  /// The segment is `count` frames of the sequence from `first` on. `frames` and `options` must
  /// outlive this object.
  SegmentInput(const SourceFrames& frames, std::size_t first, std::size_t count,
               const PackOptions& options)
      : frames_(&frames), first_(first), options_(options), kept_(count) {}

  using Cloud = std::shared_ptr<const SourceFrame>;

  /// The segment is these frames, which stay in memory. `options` must outlive this object.
  SegmentInput(std::vector<Cloud> frames, std::size_t first, const PackOptions& options)
      : first_(first), options_(options), kept_(std::move(frames)) {}

  std::size_t size() const { return kept_.size(); }
  std::string name(std::size_t frame) const;

  /// Finds the grid that the frames share. Reads all of them for this, as many at a time as the
  /// calling arena has threads. Does nothing if PackOptions::cube_per_frame is set.
  Result<void> find_shared_grid(const std::stop_token& stop);
  const std::optional<Grid>& shared_grid() const { return shared_; }
  /// The grid to encode a frame in: the shared one, or its own.
  Result<Grid> grid_of(const SourceFrame& frame) const;
  /// The strays that make the grid of a frame larger: in the shared grid, those of any frame.
  const std::string& strays_of(const SourceFrame& frame) const {
    return shared_ ? strays_ : frame.strays;
  }

  /// The cloud of a frame, which stays in memory if it was kept. From any thread. The errors of
  /// this and of `take` begin with the file.
  Result<Cloud> look(std::size_t frame) const;
  /// The same, but the cloud of a file is no longer kept: asking again reads the file again.
  /// Several threads may ask for different frames.
  Result<Cloud> take(std::size_t frame);

 private:
  Result<std::vector<FrameExtent>> read_extents(const std::stop_token& stop);
  Result<SourceFrame> read(std::size_t frame) const;

  const SourceFrames* frames_ = nullptr;  ///< null: all are kept
  const std::size_t first_;
  const PackOptions& options_;
  std::optional<Grid> shared_;
  std::string strays_;  ///< SourceFrame::strays of the first frame that has some
  std::vector<Cloud> kept_;
};

}  // namespace pointreel
