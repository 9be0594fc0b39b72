#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <variant>

#include "server/relay/relay.h"

namespace pointreel {

/// Passes a stream on to another sink in a thread of its own, so that the stream never waits for a
/// disk. The memory for what waits is bounded: frames that do not fit are left out and reported.
class SinkThread : public LiveSink {
 public:
  /// What a waiting layer takes in memory in addition to its bytes. Tiny layers are mostly this.
  static constexpr std::size_t kLayerOverhead = 512;

  /// `does` completes "frame 7 is not ...", such as "recorded". `say` may be empty.
  SinkThread(std::unique_ptr<LiveSink> sink, std::string does,
             std::function<void(const std::string& line)> say, std::size_t max_bytes = 64u << 20);
  /// Waits until the sink has got everything.
  ~SinkThread() override;

  void hello(const LiveHello& hello) override;
  void layer(const LiveLayer& layer, const LiveMessage& message) override;
  void sound(const LiveSound& sound, const LiveMessage& message) override;
  void end() override;

 private:
  struct Layer {
    LiveLayer layer;
    LiveMessage message;
  };
  struct Sound {
    LiveSound sound;
    LiveMessage message;
  };
  using Event = std::variant<LiveHello, Layer, Sound, LiveEnd>;

  static std::size_t memory_of(const LiveLayer& layer) {
    return layer.bytes.size() + kLayerOverhead;
  }
  static std::size_t memory_of(const LiveSound& sound) {
    return sound.packet.size() + kLayerOverhead;
  }
  void put(Event event);
  void run();

  const std::unique_ptr<LiveSink> sink_;
  const std::string does_;
  const std::function<void(const std::string& line)> say_;
  const std::size_t max_bytes_;
  std::optional<std::uint32_t> left_out_;  ///< the frame of which no more layers are passed on
  std::uint64_t left_out_frames_ = 0;
  std::mutex mutex_;  // guards what follows
  std::condition_variable changed_;
  std::deque<Event> events_;
  std::size_t bytes_ = 0;
  bool over_ = false;
  std::thread thread_;
};

}  // namespace pointreel
