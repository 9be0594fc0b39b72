#include "tests/fault/watcher.h"

#include <memory>
#include <utility>

#include "client/playback/reel_playback.h"
#include "client/prepare/prepare.h"
#include "client/source/open_source.h"
#include "pointreel/bytes.h"
#include "pointreel/package.h"

namespace pointreel {
namespace {

constexpr auto kLook = std::chrono::milliseconds(10);
constexpr auto kWatchPatience = std::chrono::minutes(2);

template <class T>
ByteView bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const std::uint8_t*>(values.data()), values.size() * sizeof(T)};
}

/// Opens the package at `url` for playing in a loop.
Result<std::unique_ptr<Playback>> playing(const std::string& url, const SourceOptions& reading) {
  auto source = open_source(url, reading);
  if (!source) return tl::unexpected(source.error());
  ReelPlayback::Options options;
  options.prepare.mode = DrawMode::point;
  options.prepare.pixel_size = 1e-4f;  // every detail is visible
  options.remote = true;
  Camera camera;
  camera.frame_bounds((*source)->manifest().bounds, 1.0);
  return std::make_unique<ReelPlayback>(std::move(*source), options, camera, glm::ivec2(1000, 1000),
                                        [](std::uint32_t, const Error&) {});
}

}  // namespace

std::uint64_t content_of(const SceneFrame& frame) {
  return checksum_of(bytes_of(frame.svo.masks)) ^
         3 * checksum_of(bytes_of(frame.attributes.colors));
}

Result<Truth> truth_of(const std::string& folder) {
  Truth truth;
  const auto source = open_source(folder);
  if (!source) return tl::unexpected(source.error());
  const Manifest& manifest = (*source)->manifest();
  for (std::uint32_t frame = 0; frame < manifest.frame_count(); ++frame)
    for (std::uint32_t layers = 1; layers <= manifest.layer_names.size(); ++layers) {
      const auto fetched = (*source)->fetch({frame, {.end = layers}});
      const auto scene = prepare_frame(*fetched, frame_info(manifest, frame), {DrawMode::point});
      if (scene) truth[frame].insert(content_of(*scene));
    }
  return truth;
}

Watcher::Watcher(std::string url, const Truth& truth)
    : truth_(truth), thread_([this, url = std::move(url)] { play(url); }) {}

Watcher::~Watcher() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void Watcher::play(const std::string& url) {
  SourceOptions reading;
  reading.on_trouble = [this](const std::optional<std::string>& line) {
    const std::lock_guard lock(mutex_);
    heard_of_trouble_ = heard_of_trouble_ || line.has_value();
  };
  auto opened = playing(url, reading);
  if (!opened) {
    const std::lock_guard lock(mutex_);
    trouble_ = opened.error().message;
    return;
  }
  const std::unique_ptr<Playback> playback = std::move(*opened);
  std::shared_ptr<const SceneFrame> last;
  std::unique_lock lock(mutex_);
  while (!ending_) {
    lock.unlock();
    const auto update = playback->update(Clock::now());
    const auto trouble = playback->trouble();
    std::optional<Shown> shown;
    if (update.frame && update.frame != last) {
      const auto truth = truth_.find(update.frame->index);
      shown = {Clock::now(), update.frame->index, update.frame->layers,
               truth != truth_.end() && truth->second.contains(content_of(*update.frame))};
    }
    lock.lock();
    if (!update.frame && last) ++blank_;
    if (update.frame) last = update.frame;
    if (shown) shown_.push_back(*shown);
    errors_ = playback->errors();
    trouble_ = trouble;
    changed_.notify_all();
    changed_.wait_for(lock, kLook, [this] { return ending_; });
  }
}

std::vector<Watcher::Shown> Watcher::shown() const {
  const std::lock_guard lock(mutex_);
  return shown_;
}
std::uint64_t Watcher::blank() const {
  const std::lock_guard lock(mutex_);
  return blank_;
}
std::optional<std::string> Watcher::trouble() const {
  const std::lock_guard lock(mutex_);
  return trouble_;
}
std::uint64_t Watcher::errors() const {
  const std::lock_guard lock(mutex_);
  return errors_;
}

bool Watcher::wait(const std::function<bool()>& condition) {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, kWatchPatience, condition);
}
bool Watcher::sees(std::size_t more) {
  const std::size_t wanted = shown().size() + more;
  return wait([&] { return shown_.size() >= wanted; });
}
bool Watcher::stands_still(std::chrono::milliseconds time) {
  return wait([&] { return shown_.empty() || Clock::now() - shown_.back().at >= time; });
}
bool Watcher::hears_of_trouble() {
  return wait([&] { return trouble_.has_value(); });
}
bool Watcher::heard_of_trouble() {
  return wait([&] { return heard_of_trouble_; });
}
bool Watcher::hears_of_no_trouble() {
  return wait([&] { return !trouble_.has_value(); });
}

}  // namespace pointreel
