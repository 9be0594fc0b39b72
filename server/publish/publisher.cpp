#include "server/publish/publisher.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/task_arena.h>

#include "codec/core/scalar_fields.h"
#include "codec/files/unread_properties.h"
#include "codec/live/frame_sender.h"
#include "codec/live/kept_identity.h"
#include "codec/package/coarsening.h"
#include "codec/package/standing.h"
#include "codec/package/steady_grid.h"
#include "codec/rate/frame_time_control.h"
#include "codec/surface/clean_in_time.h"
#include "common/base/out_of_memory.h"
#include "common/base/try.h"
#include "common/threads/ordered_turns.h"
#include "common/threads/tbb_executor.h"
#include "server/publish/sound_input.h"

namespace pointreel {
namespace {

using Clock = std::chrono::steady_clock;

/// The share of the frame interval that encoding may take, unless a frame time is given.
constexpr double kBudgetShare = 0.8;
/// Frames that are encoded at the same time. Each takes memory.
constexpr int kMostLanes = 8;
/// With fewer levels nobody could be recognised, and hardly any time would be saved.
constexpr int kMinDepth = 6;
double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

/// A frame on its way through the encoder.
struct FrameInProgress {
  InputFrame input;
  CleanReport cleaning = {};
  std::shared_ptr<const CleanedFrame> alone = nullptr;  ///< with EncodingOptions::clean_frames
  std::vector<std::shared_ptr<const CleanedFrame>> before = {};
  Box box = {};
  Result<Grid> grid = Grid{};
  double clean_ms = 0.0, encode_ms = 0.0;
};

/// Encodes several frames at the same time, each on a thread of its own: to divide a frame among
/// threads would take more bytes. Frames get their grids and are sent in the order in which they
/// came.
class Publisher {
 public:
  Publisher(const PublishOptions& options, const PublishListener& listener, FrameInput& input,
            int threads)
      : options_(options),
        listener_(listener),
        input_(input),
        lanes_(std::min(threads, kMostLanes)),
        arena_(threads),
        grid_(options),
        frame_time_ms_(options.frame_time_ms.value_or(kBudgetShare * 1000.0 / options.fps *
                                                      static_cast<double>(lanes_))),
        time_(frame_time_ms_, kMaxDepth, kMinDepth),
        identity_(options.outbox.url),
        sender_(
            [&] {
              OutboxOptions outbox = options.outbox;
              outbox.say = [this](const std::string& line) { say(line); };
              return outbox;
            }(),
            reel_head(options), identity_.get()) {
    options_.encode.executor = tbb_executor();
  }

  Result<PublishSummary> run() {
    const Clock::time_point start = Clock::now();
    // Frames that come before the connection would be lost, and short sequences as a whole.
    sender_.outbox().wait_until_tried(listener_.stop);
    {
      std::vector<std::jthread> others;
      // Ends with the frames.
      std::jthread sound;
      if (!options_.sound.empty())
        sound = std::jthread([this](const std::stop_token& s) { publish_sound(s); });
      for (int lane = 1; lane < lanes_; ++lane) others.emplace_back([this] { publish_frames(); });
      publish_frames();
    }
    if (sender_.sent() > 0 && !listener_.stop.stop_requested()) sender_.flush();
    if (std::optional<Error> failure = sender_.outbox().failure()) return tl::unexpected(*failure);
    summary_.skipped = input_.skipped();
    summary_.encode_ms = spread_of(std::move(encode_ms_));
    summary_.sent = sender_.outbox().statistics();
    // Whatever was not accepted until now was lost, wherever it was.
    summary_.sent.drops.frames =
        sender_.sent() - std::min<std::uint64_t>(sender_.sent(), summary_.sent.accepted_frames);
    summary_.trouble = sender_.outbox().trouble();
    summary_.seconds = 1e-3 * ms_since(start);
    return summary_;
  }

 private:
  /// Takes one frame after another until there are no more. Each lane does this on its thread.
  void publish_frames() {
    for (;;) {
      std::uint64_t turn = 0;
      std::optional<InputFrame> taken = next_frame(turn);
      if (!taken) return;
      FrameInProgress frame{*std::move(taken)};
      arena_.execute([&] { publish_frame(turn, frame); });
    }
  }

  /// From the first frame on.
  void publish_sound(const std::stop_token& stop) {
    SoundSource source{options_.sound, options_.loop_sound, 0};
    {
      std::unique_lock lock(sound_mutex_);
      if (!sound_begins_.wait(lock, stop, [this] { return first_us_ != 0; })) return;
      source.begin_us = first_us_;
    }
    const auto sent = send_sound(
        source,
        [this](ByteView packet, std::uint16_t samples, std::uint64_t capture_us) {
          sender_.send_sound(packet, samples, capture_us);
        },
        stop);
    if (!sent) {
      say(sent.error().message + "; the stream goes on in silence");
    } else if (!sent->empty()) {
      say(source.name + ": " + *sent);
    }
  }

  void begin_sound(std::uint64_t time_us) {
    const std::lock_guard lock(sound_mutex_);
    if (first_us_ == 0) first_us_ = time_us;
    sound_begins_.notify_all();
  }

  std::optional<InputFrame> next_frame(std::uint64_t& turn) {
    const std::lock_guard lock(input_mutex_);
    if (ended_) return std::nullopt;
    ended_ = true;
    if (sender_.outbox().failure()) return std::nullopt;
    auto frame = or_out_of_memory([&] { return input_.next(listener_.stop); });
    if (!frame) {
      summary_.input_error = frame.error();
      return std::nullopt;
    }
    ended_ = !*frame;
    if (*frame) {
      turn = taken_++;
      begin_sound((*frame)->capture_us);
    }
    return *std::move(frame);
  }

  void publish_frame(std::uint64_t turn, FrameInProgress& frame) {
    Result<void> usable = or_out_of_memory([&] { return clean(frame); });
    if (options_.clean_frames > 0) {
      history_turns_.take(turn, [&] { remember(frame); });
      if (usable) usable = or_out_of_memory([&] { return clean_with_those_before(frame); });
    }
    grid_turns_.take(turn, [&] {
      if (usable) usable = or_out_of_memory([&] { return find_grid(frame); });
    });
    Result<EncodedFrame> encoded = EncodedFrame{};
    if (usable) {
      encoded = or_out_of_memory([&] { return encode(frame); });
      if (!encoded) usable = tl::unexpected(encoded.error());
    }
    send_turns_.take(turn, [&] {
      if (usable) usable = or_out_of_memory([&] { return send(frame, *std::move(encoded)); });
      if (usable) return;
      ++summary_.unusable;
      say(usable.error().message + "; left out");
    });
  }

  Result<void> clean(FrameInProgress& frame) {
    if (!frame.input.cloud) return tl::unexpected(frame.input.cloud.error());
    const Clock::time_point start = Clock::now();
    PointCloud& cloud = frame.input.cloud->cloud;
    place(cloud, options_.placement);
    const EncodingOptions options = options_for_frame();
    const CleanOptions* cleaning = cleaning_of(options);
    if (options.clean_frames > 0 && cleaning != nullptr) {
      frame.alone = std::make_shared<const CleanedFrame>(
          clean_alone(std::move(cloud), *cleaning, options.encode.executor));
    } else {
      frame.cleaning = clean_frame(cloud, options);
      frame.box = bounds(cloud);
    }
    frame.clean_ms = ms_since(start);
    return {};
  }

  /// Whether the noise is worth cleaning is decided by one frame for all that follow: where it is
  /// about at the limit, some that are cleaned would flicker among others that are not.
  EncodingOptions options_for_frame() {
    EncodingOptions options = options_;
    const std::lock_guard lock(noisy_mutex_);
    if (options.clean && !options.clean->radius) options.clean->noisy = noisy_;
    return options;
  }
  void decide_cleaning(const CleanReport& report) {
    const std::lock_guard lock(noisy_mutex_);
    if (!noisy_ && (report.cleaned || report.why == NotCleaned::smooth)) noisy_ = report.cleaned;
  }

  /// In the order of the frames.
  void remember(FrameInProgress& frame) {
    frame.before.assign(history_.begin(), history_.end());
    if (frame.alone) history_.push_back(frame.alone);
    if (history_.size() > options_.clean_frames) history_.pop_front();
  }

  Result<void> clean_with_those_before(FrameInProgress& frame) {
    if (!frame.alone) return {};
    const Clock::time_point start = Clock::now();
    std::vector<const CleanedFrame*> before;
    for (const auto& one : frame.before) before.push_back(one.get());
    CleanedInTime in_time = clean_frame(*frame.alone, before, options_for_frame());
    frame.cleaning = in_time.report;
    frame.box = bounds(in_time.cloud);
    frame.input.cloud->cloud = std::move(in_time.cloud);
    frame.clean_ms += ms_since(start);
    return {};
  }

  /// In the order of the frames.
  Result<void> find_grid(FrameInProgress& frame) {
    const LoadedCloud& loaded = *frame.input.cloud;
    if (const std::string names = unread_.fresh(loaded.unread); !names.empty())
      say("properties not sent: " + names);
    if (loaded.cloud.has_scalars() && options_.encode.id() == Codec::draco &&
        !std::exchange(scalars_told_, true))
      say(kNoScalarsInDraco);
    if (options_.clean) decide_cleaning(frame.cleaning);
    if (options_.clean && !frame.cleaning.cleaned && !loaded.cloud.positions.empty() &&
        !std::exchange(uncleaned_told_, true))
      say(fmt::format("{}: not cleaned: {}", frame.input.name,
                      why_not_cleaned(*options_.clean, {{frame.cleaning.why, 1}})));
    if (!frame.box.empty() && !std::exchange(stands_told_, true)) {
      if (const auto line = standing_warning(frame.box, options_.up)) say(*line);
    }
    frame.grid = grid_.of(loaded.cloud, frame.box, frame.cleaning);
    if (!frame.grid) return fail_at(frame.input.name, frame.grid.error());
    const std::lock_guard lock(time_mutex_);
    frame.grid->encode = no_deeper_than(frame.grid->encode, time_.depth());
    return {};
  }

  Result<EncodedFrame> encode(FrameInProgress& frame) {
    const Clock::time_point start = Clock::now();
    Result<EncodedFrame> encoded =
        encode_frame(frame.input.cloud->cloud, frame.grid->cube, frame.grid->encode);
    frame.encode_ms = ms_since(start);
    if (!encoded) return fail_at(frame.input.name, encoded.error());
    return encoded;
  }

  /// In the order of the frames.
  Result<void> send(const FrameInProgress& frame, EncodedFrame encoded) {
    const int depth = encoded.depth;
    const bool scalars = encoded.has_scalars;
    const PointCloud& cloud = frame.input.cloud->cloud;
    sender_.send(std::move(encoded),
                 {frame.box, options_.encode.colors && cloud.has_colors(),
                  options_.encode.normals && cloud.has_normals(),
                  scalars ? ranges_of(cloud) : std::vector<ScalarRange>()},
                 frame.input.capture_us);
    count(depth, frame.clean_ms + frame.encode_ms, frame.clean_ms);
    return {};
  }

  void count(int depth, double ms, double clean_ms) {
    const std::lock_guard lock(time_mutex_);
    // The first frame finds cold memory, so its time says nothing about the others.
    if (summary_.frames > 0) {
      // A lower depth makes encoding faster, but not cleaning. Where that takes most of the time,
      // frames are skipped instead.
      const double counted = ms - std::max(0.0, clean_ms - kCleaningShare * frame_time_ms_);
      time_.told(depth, counted);
      tell_depth(depth, counted);
      if (options_.clean && clean_ms > frame_time_ms_ && !std::exchange(slow_cleaning_told_, true))
        say(fmt::format(
            "cleaning took {:.0f} ms, {:.0f} ms are available; frames are skipped while "
            "it takes so long: lower --fps or --clean-frames, or --clean off",
            clean_ms, frame_time_ms_));
      if (ms > frame_time_ms_) ++summary_.late;
    }
    summary_.depth_min = summary_.frames == 0 ? depth : std::min(summary_.depth_min, depth);
    summary_.depth_max = std::max(summary_.depth_max, depth);
    ++summary_.frames;
    if (encode_ms_.size() < kMaxTimes) encode_ms_.push_back(ms);
  }

  /// `depth`: of a frame, which took so long.
  void tell_depth(int depth, double ms) {
    const int allowed = time_.depth();
    if (allowed < std::min(allowed_, depth)) ++summary_.lowered;
    if (allowed < allowed_) lowered_ms_ = ms;
    allowed_ = allowed;
    // A machine that is about fast enough goes up and down all the time.
    const Clock::time_point now = Clock::now();
    const bool lower = allowed < std::min(told_depth_, std::max(depth, summary_.depth_max));
    const bool higher = allowed > told_depth_;
    if ((!lower && !higher) || (depth_told_ && now - *depth_told_ < kDepthsTold)) return;
    depth_told_ = now;
    told_depth_ = allowed;
    if (lower)
      say(fmt::format(
          "encoding took {:.0f} ms, {:.0f} ms are available; coarser from now on, depth at most {}",
          lowered_ms_, frame_time_ms_, allowed));
    else
      say(fmt::format("encoding is faster again; finer from now on, depth up to {}", allowed));
  }

  void say(const std::string& line) {
    const std::lock_guard lock(say_mutex_);
    if (listener_.say) listener_.say(line);
  }

  /// The most of the frame time that cleaning takes from encoding.
  static constexpr double kCleaningShare = 0.5;
  /// Changes of the depth are reported at most so often.
  static constexpr auto kDepthsTold = std::chrono::seconds(10);
  /// Enough for the median; later frames take about as long.
  static constexpr std::size_t kMaxTimes = 100'000;

  PublishOptions options_;
  const PublishListener& listener_;
  std::mutex say_mutex_;

  std::mutex input_mutex_;  ///< of the next three, and of summary_.input_error
  FrameInput& input_;
  bool ended_ = false;
  std::uint64_t taken_ = 0;

  std::mutex sound_mutex_;  ///< of the next two
  std::condition_variable_any sound_begins_;
  std::uint64_t first_us_ = 0;  ///< of the first frame; 0 before it

  const int lanes_;
  tbb::task_arena arena_;
  std::mutex noisy_mutex_;  ///< of the next one
  std::optional<bool> noisy_;
  OrderedTurns history_turns_;
  std::deque<std::shared_ptr<const CleanedFrame>> history_;  ///< in the turns above
  OrderedTurns grid_turns_;
  SteadyGrid grid_;  ///< used in turns only, as are the next four
  UnreadProperties unread_;
  bool scalars_told_ = false;
  bool uncleaned_told_ = false;
  bool stands_told_ = false;

  const double frame_time_ms_;
  std::mutex time_mutex_;
  FrameTimeControl time_;

  OrderedTurns send_turns_;
  // Used in turns only, as is all that follows.
  int allowed_ = kMaxDepth;     ///< the depth that was last allowed
  int told_depth_ = kMaxDepth;  ///< the one that was last told
  double lowered_ms_ = 0.0;     ///< what led to the one that is allowed
  std::optional<Clock::time_point> depth_told_;
  bool slow_cleaning_told_ = false;
  std::vector<double> encode_ms_;
  PublishSummary summary_;
  const KeptIdentity identity_;
  FrameSender sender_;  ///< destroyed first, because its thread calls `say`
};

}  // namespace

Result<PublishSummary> publish(FrameInput& input, const PublishOptions& options,
                               const PublishListener& listener) try {
  TRY(parse_websocket_url(options.outbox.url));
  const int threads = options.threads > 0 ? options.threads : tbb::info::default_concurrency();
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(threads));
  return Publisher(options, listener, input, threads).run();
} catch (const std::bad_alloc&) {
  return fail(ErrorCode::limit, "not enough memory");
}

}  // namespace pointreel
