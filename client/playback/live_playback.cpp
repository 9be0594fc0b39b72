#include "client/playback/live_playback.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "client/prepare/layer_choice.h"
#include "client/scene/cut.h"
#include "common/base/unix_time.h"
#include "common/threads/without_exceptions.h"
#include "pointreel/octree.h"

namespace pointreel {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kPatience{500};

Box bounds_of(const SceneFrame& frame) {
  return bounds(frame.cloud.empty() ? leaf_centers(frame.svo) : frame.cloud);
}

}  // namespace

LivePlayback::LivePlayback(std::unique_ptr<LiveSource> source, std::string name,
                           const Options& options, OnError on_error, OnReady on_ready)
    : source_(std::move(source)),
      on_error_(std::move(on_error)),
      on_ready_(std::move(on_ready)),
      name_(std::move(name)),
      prepare_(options.prepare) {
  try {
    receiver_ = std::jthread([this] { receive(); });
    for (unsigned i = 0; i < std::max(1u, options.prepare_threads); ++i) {
      preparers_.emplace_back([this] { prepare(); });
    }
  } catch (...) {
    end();  // the threads that there are must not wait for frames any more
    throw;
  }
}

LivePlayback::~LivePlayback() { end(); }

void LivePlayback::end() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  source_->cancel();
}

Up LivePlayback::up() const {
  const std::lock_guard lock(mutex_);
  return stream_.up;
}

double LivePlayback::frame_seconds() const {
  const std::lock_guard lock(mutex_);
  return 1.0 / std::max(stream_.fps, 1e-3);
}

Box LivePlayback::bounds() const {
  const std::lock_guard lock(mutex_);
  if (!stream_.bounds.empty() || !ready_.frame) return stream_.bounds;
  return bounds_of(*ready_.frame);
}

std::vector<ScalarRange> LivePlayback::scalars() const {
  const std::lock_guard lock(mutex_);
  return stream_.scalars;
}

void LivePlayback::look(const Camera& camera, glm::ivec2 size) {
  const std::lock_guard lock(mutex_);
  if (camera_ == camera && size_ == size) return;
  camera_ = camera;
  size_ = size;
  find_level();
}

void LivePlayback::set_prepare_options(const PrepareOptions& options) {
  const std::lock_guard lock(mutex_);
  prepare_ = options;
  find_level();
}

void LivePlayback::find_level() {
  level_ = kWholeFrame;
  if (camera_ && !stream_.bounds.empty())
    level_ = finest_level(bounding_cube(stream_.bounds), stream_.bounds, *camera_, size_,
                          prepare_.pixel_size);
}

void LivePlayback::receive() {
  bool heard = false;  // what the stream is
  std::uint64_t order = 0;
  std::optional<std::uint32_t> number;
  while (true) {
    auto frame = source_->next(kPatience);
    auto hello = source_->hello(milliseconds(0));
    bool another_hello = false;
    if (source_->refusal()) {
      if (on_ready_) on_ready_();
      return;
    }
    {
      const std::lock_guard lock(mutex_);
      if (ending_) return;
      another_hello = hello && (!heard || *hello != stream_);
      if (another_hello) {
        if (heard && stream_.session != hello->session) number.reset();
        stream_ = *std::move(hello);
        heard = true;
        find_level();
      }
      if (frame && heard) {
        if (number != frame->number) ++order;
        number = frame->number;
        if (playing_ || !ready_.frame) {
          if (received_ && received_->order < order) ++overtaken_;
          received_ = Received{order, *std::move(frame)};
          changed_.notify_one();
        }
      }
    }
    if (another_hello && on_ready_) on_ready_();
  }
}

void LivePlayback::prepare() {
  while (true) {
    Received received;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return ending_ || received_; });
      if (ending_) return;
      received = *std::exchange(received_, std::nullopt);
    }
    auto frame = without_exceptions([&] { return prepare(received.frame); });
    if (!frame) {
      ++errors_;
      on_error_(received.frame.number, frame.error());
      continue;
    }
    deliver(received.order, std::make_shared<const SceneFrame>(*std::move(frame)));
    if (on_ready_) on_ready_();
  }
}

Result<SceneFrame> LivePlayback::prepare(LiveFrame& frame) {
  FrameInfo info{frame.number, frame.capture_us, {}};
  PrepareOptions options;
  std::shared_ptr<const StripRecord> record;
  bool octree = false;
  {
    const std::lock_guard lock(mutex_);
    record = strip_record_;
    info.cube = bounding_cube(stream_.bounds);
    options = prepare_;
    info.scalars = stream_.scalars;
    options.level = std::min(options.level, level_);
    octree = stream_.codec == "octree";
  }
  // The depth may change with every frame, so that it cannot narrow the choice.
  const bool all = !octree || !options.scalar.field.empty();
  const std::uint32_t seen = all ? kAllLayers : layers_down_to(options.level, kMaxDepth);
  const std::size_t most = std::min(seen, std::max(1u, options.layers));
  std::vector<FetchedLayer>& layers = frame.frame.layers;
  if (layers.size() > most) layers.resize(most);
  auto scene = prepare_frame(frame.frame, info, options, {}, &record);
  const std::lock_guard lock(mutex_);
  strip_record_ = std::move(record);
  return scene;
}

void LivePlayback::deliver(std::uint64_t order, std::shared_ptr<const SceneFrame> frame) {
  const std::lock_guard lock(mutex_);
  const bool finer = order == ready_.order && frame->layers >= ready_.frame->layers;
  if (order < ready_.order) ++overtaken_;
  if (order > ready_.order && ready_.order > given_.order) ++overtaken_;
  if (order > ready_.order || finer) ready_ = {order, std::move(frame)};
}

Playback::Update LivePlayback::update(Clock::TimePoint) {
  const bool ended = source_->refusal().has_value();
  const std::lock_guard lock(mutex_);
  if (!playing_ && given_.frame) return {given_.frame};
  Update update{.frame = ready_.frame, .ended = ended};
  if (ready_.frame && ready_.order != given_.order) {
    const std::int64_t delay = static_cast<std::int64_t>(unix_time_us()) -
                               static_cast<std::int64_t>(ready_.frame->time_us);
    // The mean of about the last ten.
    delay_us_ = delay_us_ ? *delay_us_ + (delay - *delay_us_) / 10 : delay;
  }
  update.refined = given_.frame && given_.frame != ready_.frame && given_.order == ready_.order;
  given_ = ready_;
  return update;
}

std::optional<std::int64_t> LivePlayback::delay_us() const {
  const std::lock_guard lock(mutex_);
  return delay_us_;
}

std::uint64_t LivePlayback::dropped() const {
  const LiveCounts counts = source_->counts();
  const std::lock_guard lock(mutex_);
  return overtaken_ + counts.skipped;
}

}  // namespace pointreel
