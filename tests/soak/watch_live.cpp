#include <atomic>
#include <cmath>
#include <memory>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "client/playback/live_playback.h"
#include "client/source/open_live_source.h"
#include "common/base/try.h"
#include "server/publish/publisher.h"
#include "server/relay/relay.h"
#include "server/serve/http_server.h"
#include "tests/soak/scenario.h"
#include "tests/wait.h"

namespace pointreel::soak {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

/// The number of points, which identifies a frame; it follows from the time of its capture.
std::uint32_t points_of(std::uint64_t capture_us) {
  return 300 + static_cast<std::uint32_t>(capture_us % 997);
}

PointCloud cloud_of(std::uint32_t points) {
  PointCloud cloud;
  for (std::uint32_t i = 0; i < points; ++i) {
    const double angle = 2.399963 * i, z = 1.0 - 2.0 * (i + 0.5) / points;
    const double r = std::sqrt(1.0 - z * z);
    cloud.positions.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
    cloud.colors.emplace_back(257 * (i % 256), 30'000, 20'000);
  }
  return cloud;
}

/// An endless source of fifty frames per second.
class Camera50 : public FrameInput {
 public:
  Result<std::optional<InputFrame>> next(const std::stop_token& stop) override {
    next_us_ = std::max(next_us_ + 20'000, clock_.now_us());
    clock_.wait_until(next_us_, stop);
    if (stop.stop_requested()) return std::optional<InputFrame>();
    LoadedCloud loaded;
    loaded.cloud = cloud_of(points_of(next_us_));
    return InputFrame{"camera", next_us_, std::move(loaded)};
  }
  std::uint64_t skipped() const override { return 0; }

 private:
  const LiveClock clock_ = LiveClock::system();
  std::uint64_t next_us_ = 0;
};

/// A publisher that runs in a thread of its own until it is destroyed.
class PublishThread {
 public:
  explicit PublishThread(const std::string& url) {
    options_.name = "soak";
    options_.fps = 50.0;
    OctreeOptions octree;
    octree.entropy = Entropy::zstd;
    octree.depth = DepthRule::fixed(11);
    options_.encode.codec = octree;
    options_.outbox.url = url;
    thread_ = std::jthread([this](const std::stop_token& stop) {
      Camera50 camera;
      const auto ended = publish(camera, options_, {{}, stop});
      if (!ended)
        error_ = ended.error();
      else
        error_ = ended->input_error;
    });
  }
  /// Stops the publisher; returns its error if it had ended by itself.
  std::optional<Error> end() {
    thread_.request_stop();
    thread_.join();
    return error_;
  }

 private:
  PublishOptions options_;
  std::optional<Error> error_;  // of the thread, until it has ended
  std::jthread thread_;
};

/// A viewer with a link of its own.
class Watcher {
 public:
  static Result<std::unique_ptr<Watcher>> join(std::uint16_t port) {
    auto watcher = std::make_unique<Watcher>();
    watcher->link_ = TRY(LinkEmulator::start({.target = fmt::format("127.0.0.1:{}", port)}));
    auto source =
        TRY(open_live_source("ws://" + watcher->link_->address() + "/live/soak", SourceOptions{}));
    LivePlayback::Options options;
    options.prepare.mode = DrawMode::point;
    watcher->playback_ = std::make_unique<LivePlayback>(std::move(source), "soak", options,
                                                        [](std::uint32_t, const Error&) {});
    return watcher;
  }

  LinkEmulator& link() { return *link_; }
  std::uint64_t newest_us() const { return last_ ? last_->time_us : 0; }
  std::uint64_t shown() const { return shown_; }

  Result<void> look() {
    const auto update = playback_->update(steady_clock::now());
    if (!update.frame || update.frame == last_) return {};
    const SceneFrame& frame = *update.frame;
    if (frame.points != points_of(frame.time_us))
      return fail(fmt::format("a frame has {} points instead of {}", frame.points,
                              points_of(frame.time_us)));
    if (last_ &&
        (frame.time_us < last_->time_us || (frame.time_us == last_->time_us && !update.refined)))
      return fail("a frame was shown after a newer one, or twice");
    last_ = update.frame;
    ++shown_;
    return {};
  }

 private:
  std::unique_ptr<LinkEmulator> link_;
  std::unique_ptr<LivePlayback> playback_;
  std::shared_ptr<const SceneFrame> last_;
  std::uint64_t shown_ = 0;
};

}  // namespace

Outcome watch_live(const Options& options) {
  Relay relay;
  HttpServerOptions serving;
  serving.listen = {"127.0.0.1", 0};
  // Two publishers may meet, because the link of the old one may be cut; this would be logged.
  serving.service.log = Log::Level::kOff;
  Catalog catalog = TRY(Catalog::load({}));
  const auto server = TRY(HttpServer::start(std::move(catalog), serving, &relay));
  const std::uint16_t port = server->port();

  const auto publisher_link =
      TRY(LinkEmulator::start({.target = fmt::format("127.0.0.1:{}", port)}));
  const std::string publish_url = "ws://" + publisher_link->address() + "/live/soak?publish";
  auto publisher = std::make_unique<PublishThread>(publish_url);

  std::vector<std::unique_ptr<Watcher>> watchers(3);
  for (auto& watcher : watchers) watcher = TRY(Watcher::join(port));

  std::mt19937_64 random(options.seed);
  const auto begin = steady_clock::now();
  auto next_fault = begin, next_visitor = begin;
  auto next_publisher = begin + std::chrono::seconds(3);
  std::unique_ptr<Watcher> visitor;
  std::uint64_t visitors = 0, publishers = 1;
  const auto look = [&]() -> Result<void> {
    for (const auto& watcher : watchers) {
      if (auto good = watcher->look(); !good) return good;
    }
    return visitor ? visitor->look() : Result<void>{};
  };
  while (steady_clock::now() - begin < options.time) {
    const auto now = steady_clock::now();
    if (now >= next_fault) {
      worsen(random() % 3 == 0 ? *publisher_link : watchers[random() % watchers.size()]->link(),
             random);
      next_fault = now + milliseconds(100 + random() % 400);
    }
    if (now >= next_visitor) {
      visitor.reset();
      visitor = TRY(Watcher::join(port));
      ++visitors;
      next_visitor = now + milliseconds(random() % 500);
    }
    if (now >= next_publisher) {
      if (const auto error = publisher->end()) return tl::unexpected(*error);
      publisher = std::make_unique<PublishThread>(publish_url);
      ++publishers;
      next_publisher = now + milliseconds(1000 + random() % 4000);
    }
    if (auto good = look(); !good) return tl::unexpected(good.error());
    std::this_thread::sleep_for(milliseconds(2));  // more often than any display draws
  }

  // Once the links are good, every viewer must get new frames, no matter what happened before.
  publisher_link->set({});
  for (const auto& watcher : watchers) watcher->link().set({});
  const std::uint64_t healed_us = LiveClock::system().now_us();
  const auto all_go_on = [&] {
    return std::all_of(watchers.begin(), watchers.end(),
                       [&](const auto& watcher) { return watcher->newest_us() > healed_us; });
  };
  Result<void> good;
  if (!wait_until([&] { return !(good = look()) || all_go_on(); }))
    return fail("no new frame came over good links");
  if (!good) return tl::unexpected(good.error());
  if (const auto error = publisher->end()) return tl::unexpected(*error);
  std::uint64_t shown = 0;
  for (const auto& watcher : watchers) shown += watcher->shown();
  return fmt::format("{} frames shown by {} viewers, {} visitors, {} publishers", shown,
                     watchers.size(), visitors, publishers);
}

}  // namespace pointreel::soak
