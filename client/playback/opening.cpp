#include "client/playback/opening.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <stop_token>
#include <thread>
#include <utility>

namespace pointreel {
namespace {

constexpr std::chrono::milliseconds kPatience{100};

std::atomic<int> errands_under_way = 0;

/// Something that a thread does while another waits for a short time.
class Errand {
 public:
  Errand() { ++errands_under_way; }

  void end() {
    const std::lock_guard lock(mutex_);
    ended_ = true;
    --errands_under_way;
    changed_.notify_all();
  }
  void wait(std::chrono::milliseconds at_most) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, at_most, [this] { return ended_; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool ended_ = false;
};

}  // namespace

/// Owned by the Opening and by its thread, whichever lives longer.
struct Opening::Shared {
  Stage::CameraFor camera_for;
  Stage::OnError on_error;
  Playback::OnReady on_ready;
  std::stop_source stop;
  Errand errand;
  std::mutex calling;  ///< held while one of the functions above is called; after the one below
  bool given_up = false;
  std::mutex mutex;  ///< guards what follows
  std::optional<Opened> opened;
  bool unwanted = false;
  std::optional<std::string> trouble;

  void tell_ready() {
    const std::lock_guard lock(calling);
    if (!given_up && on_ready) on_ready();
  }
};

Opening::Opening(std::vector<Stage::Placed> sources, Stage::Options options,
                 Stage::CameraFor camera_for, Stage::OnError on_error)
    : shared_(std::make_shared<Shared>()) {
  shared_->camera_for = std::move(camera_for);
  shared_->on_error = std::move(on_error);
  shared_->on_ready = std::move(options.on_ready);
  options.on_ready = [shared = shared_] { shared->tell_ready(); };
  options.source.stop = shared_->stop.get_token();
  options.source.on_trouble = [shared = shared_](const auto& line) {
    const std::lock_guard lock(shared->mutex);
    shared->trouble = line;
  };
  const auto open = [shared = shared_, sources = std::move(sources), options = std::move(options)] {
    Opened opened = Stage::open(
        sources, options,
        [&shared](const Box& bounds, char up) {
          const std::lock_guard lock(shared->calling);
          return shared->given_up ? Camera{} : shared->camera_for(bounds, up);
        },
        [shared](std::size_t source, std::uint32_t frame, const Error& error) {
          const std::lock_guard lock(shared->calling);
          if (!shared->given_up) shared->on_error(source, frame, error);
        });
    {
      const std::lock_guard lock(shared->mutex);
      if (!shared->unwanted) {
        shared->opened = std::move(opened);
        // Told before anybody can take the stage: whoever has taken it may end, and what the
        // function uses with it, before this thread goes on.
        shared->tell_ready();
      }
    }
    opened = nullptr;  // an unwanted stage ends here
    shared->errand.end();
  };
  std::thread(open).detach();
}

Opening::~Opening() {
  shared_->stop.request_stop();
  std::optional<Opened> opened;
  bool taken = false;
  {
    const std::lock_guard lock(shared_->mutex);
    taken = std::exchange(shared_->unwanted, true);
    opened = std::exchange(shared_->opened, std::nullopt);
  }
  if (taken) return;  // the stage goes on calling the functions
  {
    const std::lock_guard lock(shared_->calling);
    shared_->given_up = true;
  }
  if (opened && *opened) retire(std::move(**opened));
  shared_->errand.wait(kPatience);
}

std::optional<Opening::Opened> Opening::poll() {
  const std::lock_guard lock(shared_->mutex);
  if (shared_->opened) shared_->unwanted = true;
  return std::exchange(shared_->opened, std::nullopt);
}

std::optional<std::string> Opening::trouble() const {
  const std::lock_guard lock(shared_->mutex);
  return shared_->trouble;
}

bool unfinished() { return errands_under_way > 0; }

void retire(std::unique_ptr<Stage> stage) {
  if (!stage) return;
  stage->silence();
  const auto errand = std::make_shared<Errand>();
  std::thread([errand, stage = std::move(stage)]() mutable {
    stage.reset();
    errand->end();
  }).detach();
  errand->wait(kPatience);
}

}  // namespace pointreel
