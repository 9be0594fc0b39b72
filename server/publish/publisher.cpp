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
#include "common/base/try.h"
#include "server/encode/unread_properties.h"
#include "server/rate/coarsening.h"
#include "server/rate/frame_time_control.h"

namespace pointreel {
namespace {

using Clock = std::chrono::steady_clock;

/// The share of the frame interval that encoding may take, unless a frame time is given.
constexpr double kBudgetShare = 0.8;
/// With fewer levels nobody could be recognised, and hardly any time would be saved.
constexpr int kMinDepth = 6;
/// How long sending the last frames may take at the end; the longer time over a link that works.
constexpr std::chrono::milliseconds kFlushTime{2000}, kSlowFlushTime{8000};

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

LiveSecret random_secret() {
  std::random_device device;
  LiveSecret secret;
  for (std::uint8_t& byte : secret) byte = static_cast<std::uint8_t>(device());
  return secret;
}

/// The messages of an encoded frame, one for each layer.
std::vector<LiveMessage> messages_of(EncodedFrame encoded, std::uint32_t number,
                                     std::uint64_t capture_us) {
  LiveLayer header;
  header.frame = number;
  header.layers = static_cast<std::uint8_t>(encoded.layers.size());
  header.capture_us = capture_us;
  header.points = encoded.source_points;
  std::vector<LiveMessage> messages;
  for (Chunks<Bytes>& layer : encoded.layers) {
    messages.push_back(layer_message(header, std::move(layer)));
    ++header.layer;
  }
  return messages;
}

class Publisher {
 public:
  Publisher(const PublishOptions& options, const PublishListener& listener)
      : options_(options),
        listener_(listener),
        grid_(options),
        frame_time_ms_(options.frame_time_ms.value_or(kBudgetShare * 1000.0 / options.fps)),
        time_(frame_time_ms_, kMaxDepth, kMinDepth),
        outbox_([&] {
          OutboxOptions outbox = options.outbox;
          outbox.say = [this](const std::string& line) { say(line); };
          return outbox;
        }()) {
    static_cast<ReelHead&>(hello_) = reel_head(options);
  }

  Result<PublishSummary> run(FrameInput& input) {
    const Clock::time_point start = Clock::now();
    // Frames that come before the connection would be lost, and short sequences as a whole.
    outbox_.wait_until_tried(listener_.stop);
    for (;;) {
      if (std::optional<Error> failure = outbox_.failure()) return tl::unexpected(*failure);
      Result<std::optional<InputFrame>> frame = input.next(listener_.stop);
      if (!frame) {
        summary_.input_error = frame.error();
        break;
      }
      if (!*frame) break;
      if (const Result<void> sent = send(**frame); !sent) {
        ++summary_.unusable;
        say(sent.error().message + "; left out");
      }
    }
    if (number_ > 0 && !listener_.stop.stop_requested()) {
      outbox_.flush(kFlushTime);
      if (outbox_.trouble().empty()) outbox_.flush(kSlowFlushTime);
    }
    if (std::optional<Error> failure = outbox_.failure()) return tl::unexpected(*failure);
    summary_.skipped = input.skipped();
    summary_.encode_ms = spread_of(std::move(encode_ms_));
    summary_.sent = outbox_.statistics();
    // Whatever was not accepted until now was lost, wherever it was.
    summary_.sent.drops.frames =
        number_ - std::min<std::uint64_t>(number_, summary_.sent.accepted_frames);
    summary_.trouble = outbox_.trouble();
    summary_.seconds = 1e-3 * ms_since(start);
    return summary_;
  }

 private:
  Result<void> send(InputFrame& frame) {
    if (!frame.cloud) return tl::unexpected(frame.cloud.error());
    if (const std::string names = unread_.fresh(frame.cloud->unread); !names.empty())
      say("PLY properties that are not sent: " + names);
    const Clock::time_point start = Clock::now();
    PointCloud& cloud = frame.cloud->cloud;
    const CleanReport cleaning = clean_frame(cloud, options_);
    const double clean_ms = ms_since(start);
    if (options_.clean && !cleaning.cleaned && !cloud.positions.empty() &&
        !std::exchange(uncleaned_told_, true))
      say(fmt::format("{}: not cleaned: {}", frame.name, why_not_cleaned(*options_.clean)));
    const Box box = bounds(cloud);
    const Result<Grid> grid = grid_.of(cloud, box, cleaning);
    if (!grid) return fail_at(frame.name, grid.error());

    Result<EncodedFrame> encoded =
        encode_frame(cloud, grid->cube, no_deeper_than(grid->encode, time_.depth()));
    const double ms = ms_since(start);
    if (!encoded) return fail_at(frame.name, encoded.error());
    const int depth = encoded->depth;
    greet(cloud, box);
    // Capture times must rise, even if two frames came within a microsecond.
    last_us_ = std::max(frame.capture_us, last_us_ + 1);
    outbox_.push(number_, messages_of(*std::move(encoded), number_, last_us_));
    ++number_;
    count(depth, ms, clean_ms);
    return {};
  }

  /// Sends a hello before the first frame, and again whenever a frame changes what it says.
  void greet(const PointCloud& cloud, const Box& box) {
    LiveHello hello = hello_;
    hello.bounds.grow(box);
    hello.colors |= options_.encode.colors && cloud.has_colors();
    hello.normals |= options_.encode.normals && cloud.has_normals();
    if (greeted_ && hello == hello_) return;
    greeted_ = true;
    hello_ = std::move(hello);
    outbox_.hello(text_message(write_publisher_hello(hello_, secret_)));
  }

  void count(int depth, double ms, double clean_ms) {
    // The first frame finds cold memory, so its time says nothing about the others.
    if (summary_.frames > 0) {
      // A lower depth makes encoding faster, but not cleaning. Where that takes most of the time,
      // frames are skipped instead.
      const double counted = ms - std::max(0.0, clean_ms - kCleaningShare * frame_time_ms_);
      time_.told(depth, counted);
      tell_depth(depth, counted);
      if (ms > frame_time_ms_) ++summary_.late;
    }
    summary_.depth_min = summary_.frames == 0 ? depth : std::min(summary_.depth_min, depth);
    summary_.depth_max = std::max(summary_.depth_max, depth);
    ++summary_.frames;
    if (encode_ms_.size() < kMaxTimes) encode_ms_.push_back(ms);
  }

  void tell_depth(int depth, double ms) {
    const int allowed = time_.depth();
    if (allowed < allowed_told_ && allowed < depth) {
      ++summary_.lowered;
      say(fmt::format("encoding took {:.0f} ms, {:.0f} ms are available; depth {} from now on", ms,
                      frame_time_ms_, allowed));
    } else if (allowed > allowed_told_) {
      say(fmt::format("encoding is fast enough again; depth up to {}", allowed));
    }
    allowed_told_ = allowed;
  }

  void say(const std::string& line) {
    const std::lock_guard lock(say_mutex_);
    if (listener_.say) listener_.say(line);
  }

  /// The most of the frame time that cleaning takes from encoding.
  static constexpr double kCleaningShare = 0.5;
  /// Enough for the median; later frames take about as long.
  static constexpr std::size_t kMaxTimes = 100'000;

  const PublishOptions& options_;
  const PublishListener& listener_;
  std::mutex say_mutex_;
  SteadyGrid grid_;
  UnreadProperties unread_;
  const double frame_time_ms_;
  FrameTimeControl time_;
  const LiveSecret secret_ = random_secret();
  LiveHello hello_;
  bool greeted_ = false, uncleaned_told_ = false;
  std::uint32_t number_ = 0;
  std::uint64_t last_us_ = 0;
  int allowed_told_ = kMaxDepth;  ///< the depth that was last reported
  std::vector<double> encode_ms_;
  PublishSummary summary_;
  Outbox outbox_;  ///< destroyed first, because its thread calls `say`
};

}  // namespace

Result<PublishSummary> publish(FrameInput& input, const PublishOptions& options,
                               const PublishListener& listener) try {
  TRY(parse_websocket_url(options.outbox.url));
  const int threads = options.threads > 0 ? options.threads : tbb::info::default_concurrency();
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(threads));
  tbb::task_arena arena(threads);
  PublishOptions parallel = options;
  parallel.encode.executor = tbb_executor();
  Publisher publisher(parallel, listener);
  return arena.execute([&] { return publisher.run(input); });
} catch (const std::bad_alloc&) {
  return fail(ErrorCode::limit, "not enough memory");
}

}  // namespace pointreel
