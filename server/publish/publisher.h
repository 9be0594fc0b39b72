#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>

#include "pointreel/codec.h"
#include "pointreel/draco.h"
#include "pointreel/error.h"
#include "server/pack/grid.h"
#include "server/pack/pack_options.h"
#include "server/pack/packer.h"
#include "server/publish/frame_input.h"
#include "server/publish/outbox.h"

namespace pointreel {

struct PublishOptions {
  std::string name;   ///< for people
  double fps = 30.0;  ///< nominal
  char up = 'y';
  EncodeOptions encode;
  std::optional<double> voxel;  ///< as in PackOptions
  /// Milliseconds that encoding a frame may take: depth is lowered rather than falling behind.
  double frame_time_ms = 0.8 * 1000.0 / 30.0;
  int threads = 0;  ///< that encode slabs of a frame; 0: as many as there are processors
  OutboxOptions outbox;
};

/// Lines for people, one call at a time.
struct PublishListener {
  std::function<void(const std::string& line)> say;
  std::stop_token stop;
};

struct PublishSummary {
  std::uint64_t frames = 0;    ///< encoded
  std::uint64_t skipped = 0;   ///< that came while others were encoded
  std::uint64_t unusable = 0;  ///< that could not be read or encoded
  std::uint64_t late = 0;      ///< that took longer than the frame time
  Spread encode_ms;
  int depth_min = 0, depth_max = 0;  ///< of the frames
  int lowered = 0;                   ///< how often depth was lowered for want of time
  OutboxStatistics sent;
  double seconds = 0.0;
};

/// Encodes frames as they come and sends them, until there are no more or it is stopped. Frames
/// that cannot be used are told and left out. An error if the input fails or the server refuses for
/// good.
Result<PublishSummary> publish(FrameInput& input, const PublishOptions& options,
                               const PublishListener& listener);

/// The cube that consecutive frames share, so that voxels do not jump between them: it stays until
/// a frame does not fit, and then has a tenth of the box to spare on each side; and holds what it
/// held before, unless that makes it more than twice as large.
class SteadyGrid {
 public:
  explicit SteadyGrid(const PublishOptions& options);
  /// The grid to encode points within `box` with.
  Result<Grid> of(const Box& box);

 private:
  PackOptions options_;
  std::optional<Grid> grid_;
  Box held_;  ///< what the grid was made for
};

}  // namespace pointreel
