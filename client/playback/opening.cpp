#include "client/playback/opening.h"

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "common/threads/without_exceptions.h"

namespace pointreel {

/// Something that a thread does while another waits for a short time.
class Errand {
 public:
  void end() {
    const std::lock_guard lock(mutex_);
    ended_ = true;
    changed_.notify_all();
  }
  bool ended() const {
    const std::lock_guard lock(mutex_);
    return ended_;
  }
  void wait(std::chrono::milliseconds at_most) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, at_most, [this] { return ended_; });
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool ended_ = false;
};

namespace {

constexpr std::chrono::milliseconds kErrandPatience{100};

/// The threads of all errands.
class Errands {
 public:
  /// Calls `work` on a new thread, or here where none can be had, and destroys it there; then the
  /// errand ends.
  template <class Work>
  void start(std::shared_ptr<Errand> errand, Work work) {
    const auto run = [errand, work = std::make_shared<std::optional<Work>>(std::move(work))] {
      (**work)();
      work->reset();
      errand->end();
    };
    std::unique_lock lock(mutex_);
    join_ended();
    running_.push_back({std::move(errand), {}});
    try {
      running_.back().thread = std::thread(run);
    } catch (const std::system_error&) {
      running_.pop_back();
      lock.unlock();
      run();
    }
  }

  bool any() {
    const std::lock_guard lock(mutex_);
    join_ended();
    return !running_.empty();
  }

 private:
  struct Running {
    std::shared_ptr<Errand> errand;
    std::thread thread;
  };

  /// Libraries still clean up after a thread whose errand has ended, with things of theirs that the
  /// end of the program destroys.
  void join_ended() {
    std::erase_if(running_, [](Running& running) {
      if (!running.errand->ended()) return false;
      running.thread.join();
      return true;
    });
  }

  std::mutex mutex_;
  std::vector<Running> running_;
};

/// Never destroyed, because its threads may outlive the program's other objects.
Errands& errands() {
  static auto* const all = new Errands;
  return *all;
}

}  // namespace

/// Owned by the Opening and by its thread, whichever lives longer.
struct Opening::Shared {
  Stage::CameraFor camera_for;
  Stage::OnError on_error;
  Playback::OnReady on_ready;
  std::stop_source stop;
  const std::shared_ptr<Errand> errand = std::make_shared<Errand>();
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
  auto open = [shared = shared_, sources = std::move(sources), options = std::move(options)] {
    Opened opened = without_exceptions([&] {
      return Stage::open(
          sources, options,
          [&shared](const Box& bounds, Up up) {
            const std::lock_guard lock(shared->calling);
            return shared->given_up ? Camera{} : shared->camera_for(bounds, up);
          },
          [shared](std::size_t source, std::uint32_t frame, const Error& error) {
            const std::lock_guard lock(shared->calling);
            if (!shared->given_up) shared->on_error(source, frame, error);
          });
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
  };
  errands().start(shared_->errand, std::move(open));
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
  shared_->errand->wait(kErrandPatience);
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

bool unfinished() { return errands().any(); }

void retire(std::unique_ptr<Stage> stage) {
  if (!stage) return;
  stage->silence();
  const auto errand = std::make_shared<Errand>();
  errands().start(errand, [stage = std::move(stage)]() mutable { stage.reset(); });
  errand->wait(kErrandPatience);
}

}  // namespace pointreel
