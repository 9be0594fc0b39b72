#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>

#include "codec/sequence/encoding_options.h"
#include "codec/sequence/grid.h"
#include "pointreel/error.h"
#include "pointreel/geometry.h"
#include "server/encode/spread.h"
#include "server/publish/frame_input.h"
#include "server/publish/outbox.h"

namespace pointreel {

/// What to publish, and where to. As many frames are encoded at the same time as there are threads.
/// Without `frame_time_ms`, they use 80 % of these threads' time.
struct PublishOptions : EncodingOptions {
  OutboxOptions outbox;
};

struct PublishListener {
  std::function<void(const std::string& line)> say;  ///< lines for people, one call at a time
  std::stop_token stop;
};

struct PublishSummary {
  std::uint64_t frames = 0;    ///< encoded
  std::uint64_t skipped = 0;   ///< arrived while all threads encoded others
  std::uint64_t unusable = 0;  ///< could not be read or encoded
  std::uint64_t late = 0;      ///< took longer than the frame time
  Spread encode_ms;            ///< of each frame, with cleaning
  int depth_min = 0, depth_max = 0;
  int lowered = 0;  ///< how often the depth was lowered because encoding took too long
  OutboxStatistics sent;
  std::string trouble;               ///< why nothing could be sent at the end; may be empty
  std::optional<Error> input_error;  ///< why the input ended before its end
  double seconds = 0.0;
};

/// Encodes frames as they come and sends them, until there are no more or it is stopped. Frames
/// that cannot be used are reported and left out. An error if the server refuses the publisher for
/// good.
Result<PublishSummary> publish(FrameInput& input, const PublishOptions& options,
                               const PublishListener& listener);

/// A cube that consecutive frames share, so that voxels do not jump between them. It stays until a
/// frame does not fit. Then it gets a margin of a tenth of the frame's box on each side, and still
/// holds what the previous cube was made for, unless that would make it more than twice as large. A
/// cube eight times as large as a frame is made anew.
/// Voxelised frames are coded on their own lattice, as pack does, so that they come back exactly or
/// without a shift, and the cells of cleaned frames are those that fit their points, until these
/// change by a quarter.
class SteadyGrid {
 public:
  explicit SteadyGrid(const EncodingOptions& options) : options_(options) {}
  /// The grid to encode a cloud in, whose points lie within `box`.
  Result<Grid> of(const PointCloud& cloud, const Box& box, const CleanReport& cleaning = {});

 private:
  EncodingOptions options_;
  std::optional<Grid> grid_;
  Box held_;                             ///< what the grid was made for
  std::optional<PointLattice> lattice_;  ///< of the frames that it was made for
  bool on_lattice_ = false;              ///< the grid's cells are the lattice's
};

}  // namespace pointreel
