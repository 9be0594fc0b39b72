#include "server/publish/publisher.h"

#include <algorithm>
#include <chrono>
#include <mutex>
#include <random>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/task_arena.h>

#include "common/base/tbb_executor.h"
#include "pointreel/chunks.h"
#include "pointreel/draco.h"
#include "pointreel/octree.h"
#include "server/rate/coarsening.h"
#include "server/rate/frame_time_control.h"

namespace pointreel {
namespace {

using Clock = std::chrono::steady_clock;

/// Of the box, on each side.
constexpr double kMargin = 0.1;
/// Of the edge that one frame's box needs.
constexpr double kMostGrowth = 2.0;
/// With fewer levels nobody is recognised, and hardly any time is saved.
constexpr int kLeastDepth = 6;
/// To send what is left at the end.
constexpr std::chrono::milliseconds kFlushTime{2000};

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

Box with_margin(const Box& box) {
  if (box.empty()) return box;
  const glm::dvec3 margin = kMargin * box.extent();
  return {box.min - margin, box.max + margin};
}

double longest(const Box& box) {
  const glm::dvec3 extent = box.extent();
  return std::max({extent.x, extent.y, extent.z});
}

bool holds(const Box& outer, const Box& inner) {
  return inner.empty() || (!outer.empty() && glm::all(glm::lessThanEqual(outer.min, inner.min)) &&
                           glm::all(glm::greaterThanEqual(outer.max, inner.max)));
}

std::uint64_t random_session() {
  std::random_device device;
  return std::uint64_t{device()} << 32 | device();
}

/// The messages of an encoded frame, a layer each.
std::vector<LiveMessage> messages_of(const EncodedFrame& encoded, std::uint32_t number,
                                     std::uint64_t capture_us) {
  std::vector<LiveMessage> messages;
  for (const Chunks<Bytes>& layer : encoded.layers) {
    Bytes bytes;
    bytes.reserve(total(layer));
    for (const Bytes* chunk : {&layer.geometry, &layer.colors, &layer.normals}) {
      bytes.insert(bytes.end(), chunk->begin(), chunk->end());
    }
    LiveLayer message;
    message.frame = number;
    message.layer = static_cast<std::uint8_t>(messages.size());
    message.layers = static_cast<std::uint8_t>(encoded.layers.size());
    message.capture_us = capture_us;
    message.points = encoded.source_points;
    message.sizes = {static_cast<std::uint32_t>(layer.geometry.size()),
                     static_cast<std::uint32_t>(layer.colors.size()),
                     static_cast<std::uint32_t>(layer.normals.size())};
    message.bytes = bytes;
    messages.push_back(
        {LiveMessage::Kind::binary, std::make_shared<const Bytes>(write_live_layer(message))});
  }
  return messages;
}

class Publisher {
 public:
  Publisher(const PublishOptions& options, const PublishListener& listener)
      : options_(options),
        listener_(listener),
        grid_(options),
        time_(options.frame_time_ms, kMaxDepth, kLeastDepth),
        outbox_([&] {
          OutboxOptions outbox = options.outbox;
          outbox.say = [this](const std::string& line) { say(line); };
          return outbox;
        }()) {
    hello_.name = options.name;
    hello_.session = random_session();
    hello_.codec = name(options.encode.id());
    if (const auto* octree = std::get_if<OctreeOptions>(&options.encode.codec)) {
      hello_.entropy = name(octree->entropy);
      hello_.layer_names = {"base", "middle", "full"};
    } else {
      hello_.layer_names = {"full"};
    }
    hello_.fps = options.fps;
    hello_.up = options.up;
  }

  Result<PublishSummary> run(FrameInput& input) {
    const Clock::time_point start = Clock::now();
    for (;;) {
      if (std::optional<Error> failure = outbox_.failure()) return tl::unexpected(*failure);
      Result<std::optional<InputFrame>> frame = input.next(listener_.stop);
      if (!frame) return tl::unexpected(frame.error());
      if (!*frame) break;
      const Result<void> taken = take(**frame);
      if (taken) continue;
      ++summary_.unusable;
      say(fmt::format("{}: {}; left out", (*frame)->name, taken.error().message));
    }
    if (!listener_.stop.stop_requested()) outbox_.flush(kFlushTime);
    if (std::optional<Error> failure = outbox_.failure()) return tl::unexpected(*failure);
    summary_.skipped = input.skipped();
    summary_.late = time_.late();
    summary_.encode_ms = spread_of(std::move(encode_ms_));
    summary_.sent = outbox_.statistics();
    summary_.seconds = 1e-3 * ms_since(start);
    return summary_;
  }

 private:
  Result<void> take(const InputFrame& frame) {
    if (!frame.cloud) return tl::unexpected(frame.cloud.error());
    const PointCloud& cloud = frame.cloud->cloud;
    const Box box = bounds(cloud);
    const Result<Grid> grid = grid_.of(box);
    if (!grid) return tl::unexpected(grid.error());

    const int depth = time_.depth();
    const Clock::time_point start = Clock::now();
    const Result<EncodedFrame> encoded =
        encode_frame(cloud, grid->cube, no_deeper_than(grid->encode, depth));
    const double ms = ms_since(start);
    if (!encoded) return tl::unexpected(encoded.error());
    greet(cloud, box);
    // Times rise, whatever is done to the clock meanwhile.
    last_us_ = std::max(frame.capture_us, last_us_ + 1);
    outbox_.push(number_, messages_of(*encoded, number_, last_us_));
    ++number_;

    // The first one finds the memory cold, which says nothing of the others.
    if (summary_.frames > 0) {
      time_.told(encoded->depth, ms);
      tell_depth(encoded->depth, ms);
    }
    summary_.depth_min =
        summary_.frames == 0 ? encoded->depth : std::min(summary_.depth_min, encoded->depth);
    summary_.depth_max = std::max(summary_.depth_max, encoded->depth);
    ++summary_.frames;
    if (encode_ms_.size() < kMostTimes) encode_ms_.push_back(ms);
    return {};
  }

  /// Says hello before the first frame, and again before one that has more than was told.
  void greet(const PointCloud& cloud, const Box& box) {
    LiveHello hello = hello_;
    hello.bounds.grow(box);
    hello.colors |= options_.encode.colors && cloud.has_colors();
    hello.normals |= options_.encode.normals && cloud.has_normals();
    if (greeted_ && hello == hello_) return;
    greeted_ = true;
    hello_ = std::move(hello);
    outbox_.hello(text_message(write_hello(hello_)));
  }

  void tell_depth(int depth, double ms) {
    const int most = time_.depth();
    if (most < most_told_ && most < depth) {
      ++summary_.lowered;
      say(fmt::format("encoding took {:.0f} ms of {:.0f}: depth {} from now on", ms,
                      options_.frame_time_ms, most));
    } else if (most > most_told_) {
      say(fmt::format("there is time again: depth up to {}", most));
    }
    most_told_ = most;
  }

  void say(const std::string& line) {
    const std::lock_guard lock(say_mutex_);
    if (listener_.say) listener_.say(line);
  }

  /// For the median; later frames are like them.
  static constexpr std::size_t kMostTimes = 100'000;

  const PublishOptions& options_;
  const PublishListener& listener_;
  std::mutex say_mutex_;
  SteadyGrid grid_;
  FrameTimeControl time_;
  LiveHello hello_;
  bool greeted_ = false;
  std::uint32_t number_ = 0;
  std::uint64_t last_us_ = 0;
  int most_told_ = kMaxDepth;
  std::vector<double> encode_ms_;
  PublishSummary summary_;
  Outbox outbox_;  ///< ends first: it says how it fares
};

}  // namespace

SteadyGrid::SteadyGrid(const PublishOptions& options) {
  options_.encode = options.encode;
  options_.voxel = options.voxel;
}

Result<Grid> SteadyGrid::of(const Box& box) {
  if (grid_ && holds({grid_->cube.origin, grid_->cube.origin + grid_->cube.edge}, box))
    return *grid_;
  Box roomy = with_margin(box);
  // What moves about comes back to where it was.
  Box both = roomy;
  both.grow(held_);
  if (longest(both) <= kMostGrowth * longest(roomy)) roomy = both;
  const Result<Grid> grid = grid_for(roomy, options_);
  if (!grid) return grid;
  grid_ = *grid;
  held_ = roomy;
  return grid;
}

Result<PublishSummary> publish(FrameInput& input, const PublishOptions& options,
                               const PublishListener& listener) try {
  if (const auto url = parse_websocket_url(options.outbox.url); !url) {
    return tl::unexpected(url.error());
  }
  const int threads = options.threads > 0 ? options.threads : tbb::info::default_concurrency();
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(threads));
  tbb::task_arena arena(threads);
  PublishOptions parallel = options;
  parallel.encode.executor = tbb_executor();
  Publisher publisher(parallel, listener);
  Result<PublishSummary> summary;
  arena.execute([&] { summary = publisher.run(input); });
  return summary;
} catch (const std::bad_alloc&) {
  return fail("not enough memory");
}

}  // namespace pointreel
