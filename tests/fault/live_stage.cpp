#include "tests/fault/live_stage.h"

#include <utility>

#include "client/source/open_live_source.h"
#include "codec/live/live.h"
#include "common/base/unix_time.h"
#include "common/net/websocket.h"
#include "pointreel/chunks.h"
#include "pointreel/draco.h"
#include "pointreel/package.h"
#include "tests/fault/turning_ball.h"
#include "tests/live_layer.h"

namespace pointreel {
namespace {

using std::chrono::milliseconds;

constexpr int kFrames = 64;
constexpr auto kPatience = std::chrono::minutes(2);

std::optional<std::uint64_t> content_of(const std::vector<Chunks<ByteView>>& layers) {
  const auto decoded = decode_frame(layers);
  if (!decoded) return std::nullopt;
  const auto hash = [](const auto& values) {
    return checksum_of(
        {reinterpret_cast<const std::uint8_t*>(values.data()), values.size() * sizeof(values[0])});
  };
  return hash(decoded->svo->masks) ^ 3 * hash(decoded->cloud.colors);
}

}  // namespace

const LiveReel& LiveReel::get() {
  static const LiveReel reel;
  return reel;
}

LiveReel::LiveReel() {
  OctreeOptions octree;
  octree.depth = DepthRule::fixed(10);
  EncodeOptions options;
  options.codec = octree;
  for (int i = 0; i < kFrames; ++i) {
    frames_.push_back(*encode_frame(turning_ball(i), Cube{glm::dvec3(-1.0), 2.0}, options));
    const std::vector<Chunks<ByteView>> views = layer_views(frames_.back().layers);
    truth_.emplace_back();
    for (std::size_t n = 1; n <= views.size(); ++n)
      truth_.back().push_back(*content_of({views.begin(), views.begin() + n}));
  }
}

std::optional<bool> LiveReel::is_right(const LiveFrame& frame) const {
  std::vector<Chunks<ByteView>> views;
  for (const FetchedLayer& layer : frame.frame.layers) views.push_back(layer.view());
  const auto content = content_of(views);
  if (!content) return std::nullopt;
  const std::uint64_t which = frame.capture_us % 1000;
  if (which >= truth_.size()) return false;
  const auto& truth = truth_[which];
  return views.size() <= truth.size() && truth[views.size() - 1] == *content;
}

StagePublisher::StagePublisher(std::string url)
    : url_(std::move(url)), thread_([this] { run(); }) {}

StagePublisher::~StagePublisher() {
  ending_ = true;
  thread_.join();
}

void StagePublisher::run() {
  LiveHello hello;
  hello.name = "ball";
  static std::atomic<std::uint8_t> publishers{0};
  LiveSecret secret{};
  secret[0] = ++publishers;
  hello.codec = "octree";
  hello.entropy = "context";
  hello.colors = true;
  hello.layer_names = {"base", "middle", "full"};
  const std::string text = write_publisher_hello(hello, {secret});
  auto due = std::chrono::steady_clock::now();
  std::uint32_t number = 0;
  while (!ending_) {
    auto socket = WebSocket::connect(url_);
    bool open = socket.has_value();
    if (open)
      open = (*socket)
                 ->send({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()},
                        WebSocket::Kind::text)
                 .has_value();
    // Capturing continues whether the publisher is connected or not.
    do {
      const EncodedFrame& frame = LiveReel::get().frame(++number);
      const std::uint64_t captured = LiveReel::get().capture_us(unix_time_us(), number);
      for (std::size_t i = 0; i < frame.layers.size() && open; ++i) {
        const Chunks<Bytes>& layer = frame.layers[i];
        Bytes bytes = layer.geometry;
        bytes.insert(bytes.end(), layer.colors.begin(), layer.colors.end());
        const Chunks<std::uint32_t> sizes{static_cast<std::uint32_t>(layer.geometry.size()),
                                          static_cast<std::uint32_t>(layer.colors.size()), 0};
        open = (*socket)
                   ->send(write_live_layer({number, static_cast<std::uint8_t>(i),
                                            static_cast<std::uint8_t>(frame.layers.size()),
                                            captured, frame.source_points, sizes, bytes}),
                          WebSocket::Kind::binary)
                   .has_value();
      }
      newest_us_ = captured;
      due += std::chrono::microseconds(33'333);
      std::this_thread::sleep_until(due);  // a camera captures a frame when it is due
    } while (open && !ending_);
  }
}

LiveWatcher::LiveWatcher(const std::string& url) {
  auto source = open_live_source(url, {});
  if (!source) return;
  source_ = std::move(*source);
  thread_ = std::thread([this] { watch(); });
}

LiveWatcher::~LiveWatcher() {
  if (!source_) return;
  ending_ = true;
  source_->cancel();
  thread_.join();
}

void LiveWatcher::watch() {
  while (!ending_) {
    const auto frame = source_->next(milliseconds(100));
    if (frame) {
      const auto right = LiveReel::get().is_right(*frame);
      const std::lock_guard lock(mutex_);
      if (right)
        shown_.push_back({std::chrono::steady_clock::now(), frame->number, frame->capture_us,
                          static_cast<std::uint32_t>(frame->frame.layers.size()), *right});
      else
        ++undecodable_;
    }
    changed_.notify_all();
  }
}

std::vector<LiveWatcher::Shown> LiveWatcher::shown() const {
  const std::lock_guard lock(mutex_);
  return shown_;
}

std::uint64_t LiveWatcher::undecodable() const {
  const std::lock_guard lock(mutex_);
  return undecodable_;
}

bool LiveWatcher::sees(std::size_t more) {
  std::unique_lock lock(mutex_);
  const std::size_t wanted = shown_.size() + more;
  return changed_.wait_for(lock, kPatience, [&] { return shown_.size() >= wanted; });
}

bool LiveWatcher::sees_what_is_as_new_as(std::uint64_t capture_us) {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(
      lock, kPatience, [&] { return !shown_.empty() && shown_.back().capture_us >= capture_us; });
}

bool LiveWatcher::hears_of_trouble(bool there) {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, kPatience, [&] { return trouble().has_value() == there; });
}

bool LiveWatcher::connects_again() {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, kPatience, [&] { return counts().reconnections > 0; });
}

}  // namespace pointreel
