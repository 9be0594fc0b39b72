#include "client/playback/live_playback.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "client/prepare/layer_choice.h"
#include "client/prepare/prepare.h"
#include "common/stream/live.h"
#include "pointreel/octree.h"

namespace pointreel {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kPatience{500};

/// A reel of one frame that has all that is known of the stream, for those who ask a manifest.
Manifest reel_of(const LiveHello& hello) {
  Manifest manifest;
  static_cast<ReelHead&>(manifest) = hello;
  manifest.depth_max = kMaxDepth;  // it may change with every frame
  manifest.bounds = hello.bounds;
  Segment segment;
  segment.cube = bounding_cube(hello.bounds);
  segment.times_us = {0};
  segment.points = {0};
  manifest.segments.push_back(std::move(segment));
  return manifest;
}

Box bounds_of(const SceneFrame& frame) {
  return bounds(frame.cloud.empty() ? leaf_centers(frame.svo) : frame.cloud);
}

}  // namespace

LivePlayback::LivePlayback(std::unique_ptr<LiveSource> source, std::string name,
                           const Options& options, OnError on_error)
    : source_(std::move(source)),
      options_(options),
      on_error_(std::move(on_error)),
      name_(std::move(name)),
      mode_(options.mode),
      delta_(options.delta),
      show_normals_(options.show_normals),
      stream_(reel_of({})),
      pixel_size_(options.pixel_size) {
  receiver_ = std::thread([this] { receive(); });
  for (unsigned i = 0; i < std::max(1u, options.prepare_threads); ++i) {
    preparers_.emplace_back([this] { prepare(); });
  }
}

LivePlayback::~LivePlayback() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  source_->cancel();
  receiver_.join();
  for (std::thread& thread : preparers_) thread.join();
}

char LivePlayback::up() const {
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

void LivePlayback::look(const Camera& camera, glm::ivec2 size) {
  const std::lock_guard lock(mutex_);
  if (camera_ == camera && size_ == size) return;
  camera_ = camera;
  size_ = size;
  find_level();
}

void LivePlayback::set_pixel_size(float pixel_size) {
  const std::lock_guard lock(mutex_);
  pixel_size_ = pixel_size;
  find_level();
}

void LivePlayback::find_level() {
  level_ = camera_ && !stream_.bounds.empty() ? level_for(stream_, *camera_, size_, pixel_size_)
                                              : kWholeFrame;
}

void LivePlayback::receive() {
  std::optional<LiveHello> hello;
  std::uint64_t order = 0;
  std::optional<std::uint32_t> number;
  while (true) {
    auto frame = source_->next(kPatience);
    auto said = source_->hello(milliseconds(0));
    const std::lock_guard lock(mutex_);
    if (ending_) return;
    if (said && said != hello) {
      if (hello && hello->session != said->session) number.reset();
      hello = std::move(said);
      stream_ = reel_of(*hello);
      find_level();
    }
    if (!frame || !hello) continue;
    if (number != frame->number) ++order;
    number = frame->number;
    if (!playing_ && ready_.frame) continue;
    if (received_ && received_->order < order) ++overtaken_;
    received_ = Received{order, *std::move(frame)};
    changed_.notify_one();
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
    auto frame = prepare(received.frame);
    if (!frame) {
      ++errors_;
      on_error_(received.frame.number, frame.error());
      continue;
    }
    deliver(received.order, std::make_shared<const SceneFrame>(*std::move(frame)));
  }
}

Result<SceneFrame> LivePlayback::prepare(LiveFrame& frame) const {
  PrepareOptions options{mode_, delta_, kWholeFrame, show_normals_};
  Manifest stream;
  {
    const std::lock_guard lock(mutex_);
    stream = stream_;
    options.level = level_;
  }
  const FetchRequest choice = layer_choice(stream, options.mode, options.level);
  const std::size_t most = std::min(choice.layers, std::max(1u, options_.layers));
  std::vector<FetchedLayer>& layers = frame.frame.layers;
  if (layers.size() > most) layers.resize(most);
  auto scene = prepare_frame(stream, 0, frame.frame, options);
  if (!scene) return scene;
  scene->index = frame.number;
  scene->time_us = frame.capture_us;
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
  const std::lock_guard lock(mutex_);
  if (!playing_ && given_.frame) return {given_.frame};
  Update update{ready_.frame};
  update.refined = given_.frame && given_.frame != ready_.frame && given_.order == ready_.order;
  given_ = ready_;
  return update;
}

std::uint64_t LivePlayback::dropped() const {
  const LiveCounts counts = source_->counts();
  const std::lock_guard lock(mutex_);
  return overtaken_ + counts.skipped;
}

}  // namespace pointreel
