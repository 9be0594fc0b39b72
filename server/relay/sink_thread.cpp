#include "server/relay/sink_thread.h"

#include <bit>
#include <chrono>
#include <utility>

#include <fmt/format.h>

namespace pointreel {

SinkThread::SinkThread(std::unique_ptr<LiveSink> sink, std::string does,
                       std::function<void(const std::string& line)> say, std::size_t max_bytes)
    : sink_(std::move(sink)),
      does_(std::move(does)),
      say_(std::move(say)),
      max_bytes_(max_bytes),
      thread_([this] { run(); }) {}

SinkThread::~SinkThread() {
  {
    const std::lock_guard lock(mutex_);
    over_ = true;
    changed_.notify_all();
  }
  thread_.join();
}

void SinkThread::hello(const LiveHello& hello) {
  left_out_.reset();
  put(hello);
}

void SinkThread::end() { put(LiveEnd{}); }

void SinkThread::layer(const LiveLayer& layer, const LiveMessage& message) {
  if (left_out_ == layer.frame) return;
  bool full = false;
  {
    const std::lock_guard lock(mutex_);
    full = bytes_ + memory_of(layer) > max_bytes_;
    if (!full) bytes_ += memory_of(layer);
  }
  if (!full) {
    put(Layer{layer, message});
    return;
  }
  left_out_ = layer.frame;
  // Reports the first frame, and then, more and more rarely, the 2nd, 4th, 8th and so on.
  ++left_out_frames_;
  if (say_ && std::has_single_bit(left_out_frames_)) {
    say_(fmt::format(
        "frame {} is not {} completely, because this machine is too slow for it ({} so far)",
        layer.frame, does_, left_out_frames_));
  }
}

/// Sound that does not fit is silence.
void SinkThread::sound(const LiveSound& sound, const LiveMessage& message) {
  {
    const std::lock_guard lock(mutex_);
    if (bytes_ + memory_of(sound) > max_bytes_) return;
    bytes_ += memory_of(sound);
  }
  put(Sound{sound, message});
}

void SinkThread::put(Event event) {
  const std::lock_guard lock(mutex_);
  events_.push_back(std::move(event));
  changed_.notify_all();
}

void SinkThread::run() {
  constexpr std::chrono::seconds kPause{1};
  std::unique_lock lock(mutex_);
  bool settled = true;
  for (;;) {
    const auto is_wanted = [&] { return over_ || !events_.empty(); };
    if (settled) {
      changed_.wait(lock, is_wanted);
    } else if (!changed_.wait_for(lock, kPause, is_wanted)) {
      lock.unlock();
      settled = sink_->settle();
      lock.lock();
      continue;
    }
    if (events_.empty()) return;
    const Event event = std::move(events_.front());
    events_.pop_front();
    lock.unlock();
    if (const auto* hello = std::get_if<LiveHello>(&event)) {
      sink_->hello(*hello);
    } else if (const auto* layer = std::get_if<Layer>(&event)) {
      sink_->layer(layer->layer, layer->message);
    } else if (const auto* sound = std::get_if<Sound>(&event)) {
      sink_->sound(sound->sound, sound->message);
    } else {
      sink_->end();
    }
    settled = !std::holds_alternative<LiveEnd>(event);
    lock.lock();
    if (const auto* layer = std::get_if<Layer>(&event)) bytes_ -= memory_of(layer->layer);
    if (const auto* sound = std::get_if<Sound>(&event)) bytes_ -= memory_of(sound->sound);
  }
}

}  // namespace pointreel
