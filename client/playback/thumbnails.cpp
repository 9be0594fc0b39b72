#include "client/playback/thumbnails.h"

#include <algorithm>
#include <utility>

#include <sys/resource.h>
#include <tbb/task_arena.h>
#include <unistd.h>

#include "client/prepare/layer_choice.h"
#include "client/prepare/prepare.h"
#include "common/base/try.h"
#include "common/threads/without_exceptions.h"

namespace pointreel {
namespace {

/// How many requests wait: the pointer has moved on from where the older ones were made.
constexpr std::size_t kMostWanted = 8;
constexpr int kNice = 10;

/// The memory of an entry besides its frame.
constexpr std::uint64_t kEntryBytes = 128;

}  // namespace

Thumbnails::Thumbnails(Source& source, Stored stored, std::uint64_t bytes,
                       std::function<void()> on_ready)
    : source_(source), stored_(std::move(stored)), budget_(bytes), on_ready_(std::move(on_ready)) {}

Thumbnails::~Thumbnails() {
  {
    const std::lock_guard lock(mutex_);
    stop_.request_stop();
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

std::shared_ptr<const SceneFrame> Thumbnails::get(std::uint32_t frame) {
  const std::lock_guard lock(mutex_);
  if (const auto it = entries_.find(frame); it != entries_.end()) {
    it->second.used = ++uses_;
    return it->second.frame;
  }
  std::erase(wanted_, frame);
  if (making_ != frame) wanted_.push_back(frame);
  if (wanted_.size() > kMostWanted) wanted_.erase(wanted_.begin());
  if (!thread_.joinable()) thread_ = std::thread([this] { run(); });
  changed_.notify_all();
  return nullptr;
}

void Thumbnails::set_quiet(bool quiet) {
  const std::lock_guard lock(mutex_);
  if (quiet_ == quiet) return;
  quiet_ = quiet;
  changed_.notify_all();
}

std::uint64_t Thumbnails::bytes() const {
  const std::lock_guard lock(mutex_);
  return bytes_;
}

void Thumbnails::run() {
  // On Linux each thread has a niceness of its own. If it cannot be set, nothing is lost.
  ::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), kNice);
  // It gets no help from other threads, which prepare the frames that are played.
  tbb::task_arena alone(1);
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return stop_.stop_requested() || (!quiet_ && !wanted_.empty()); });
    if (stop_.stop_requested()) return;
    const std::uint32_t frame = wanted_.back();
    wanted_.pop_back();
    making_ = frame;
    lock.unlock();
    auto made = without_exceptions([&] { return alone.execute([&] { return make(frame); }); });
    lock.lock();
    making_.reset();
    if (stop_.stop_requested()) return;
    keep(frame, made ? std::make_shared<const SceneFrame>(*std::move(made)) : nullptr);
    if (!on_ready_) continue;
    lock.unlock();
    on_ready_();
    lock.lock();
  }
}

Result<SceneFrame> Thumbnails::make(std::uint32_t frame) {
  auto stored = stored_(frame);
  if (!stored) {
    FetchRequest request{.frame = frame,
                         .layers = layer_choice(source_.manifest(), DrawMode::point, kLevel),
                         .stop = stop_.get_token()};
    request.layers.end = 1;
    stored = TRY(source_.fetch(request));
  }
  return prepare_frame(*stored, frame_info(source_.manifest(), frame),
                       {.mode = DrawMode::point, .level = kLevel},
                       [this] { return stop_.stop_requested(); });
}

/// Call this with the mutex held.
void Thumbnails::keep(std::uint32_t frame, std::shared_ptr<const SceneFrame> made) {
  Entry& entry = entries_[frame];
  entry.bytes = kEntryBytes + (made ? memory_of(*made) : 0);
  entry.frame = std::move(made);
  entry.used = ++uses_;
  bytes_ += entry.bytes;
  while (bytes_ > budget_ && entries_.size() > 1) {
    const auto oldest = std::min_element(
        entries_.begin(), entries_.end(),
        [](const auto& a, const auto& b) { return a.second.used < b.second.used; });
    bytes_ -= oldest->second.bytes;
    entries_.erase(oldest);
  }
}

}  // namespace pointreel
