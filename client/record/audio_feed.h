#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <span>
#include <stop_token>
#include <thread>

#include "codec/audio/opus_reader.h"
#include "pointreel/error.h"

namespace pointreel {

/// The sound of a recording.
struct RecordedSound {
  /// Gives the samples from number `first` on, counted from the first picture. Called by one thread
  /// at a time.
  std::function<Result<void>(std::uint64_t first, std::span<StereoSample> samples)> read;
  /// When the last picture ends, since the first one, if that is known before.
  std::optional<std::uint64_t> end_us = {};
};

/// Writes sound to a socket on a thread of its own, as 32-bit floats of both channels in turn: a
/// program that reads pictures and sound asks for either as it likes.
class AudioFeed {
 public:
  /// The socket is closed with the sound's end.
  AudioFeed(int socket, RecordedSound sound);
  /// Gives up.
  ~AudioFeed();
  AudioFeed(const AudioFeed&) = delete;
  AudioFeed& operator=(const AudioFeed&) = delete;

  /// Sound may be written until its known end, or else until some time after `time_us`, since the
  /// first picture. Does not wait.
  void allow(std::uint64_t time_us);
  /// Waits until the sound has been written that lasts until exactly `end_us`, or up to a second
  /// longer if that is not the end that was known. The error is that of the sound; a reader that
  /// has gone is none.
  Result<void> finish(std::uint64_t end_us);

 private:
  void run(const std::stop_token& stop);
  bool send(std::span<const StereoSample> samples) const;

  const int socket_;
  const RecordedSound sound_;
  std::mutex mutex_;  ///< guards what follows
  std::condition_variable_any changed_;
  std::uint64_t allowed_ = 0;  ///< samples
  bool last_ = false;          ///< no more will be allowed
  Result<void> result_;
  std::jthread thread_;  ///< last, because it uses everything above
};

}  // namespace pointreel
