#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "pointreel/error.h"
#include "server/relay/recorded_package.h"
#include "server/relay/relay.h"
#include "server/relay/segmenter.h"

namespace pointreel {

struct LiveRecorderOptions {
  std::filesystem::path folder;  ///< in which packages are created
  std::string name;              ///< of the stream and of its first package
  std::uint64_t segment_us = 1'000'000;
  /// If the manifest gets longer than this, the recording continues in another package.
  std::size_t manifest_bytes = 8u << 20;
  /// The most bytes of segments that wait in memory while nothing can be written.
  std::uint64_t waiting_bytes = 16u << 20;
  /// Called with one line if something goes wrong, and when that is over. May be empty.
  std::function<void(const std::string& line)> say;
};

/// Records a stream into packages: FOLDER/NAME, and then NAME-2 and so on for each new session and
/// whenever a manifest gets too long. Existing files and folders are never touched.
///
/// While nothing can be written, for instance because the disk is full, the newest segments wait in
/// memory, and older ones are lost. Then the recording continues in the same package.
class LiveRecorder : public LiveSink {
 public:
  explicit LiveRecorder(LiveRecorderOptions options);
  ~LiveRecorder() override;

  void hello(const LiveHello& hello) override;
  void layer(const LiveLayer& layer, const LiveMessage& message) override;
  void sound(const LiveSound& sound, const LiveMessage& message) override;
  void end() override;
  bool settle() override;

 private:
  void append(LiveSegment segment);
  void write_waiting();
  void write_sound();
  Result<void> record(LiveSegment& segment);
  Result<void> open(const LiveSegment& first);
  /// Completes the package for now: the publisher may come back. Whether that was possible.
  bool pause();
  /// Completes the package, so that the next segment begins another one.
  void complete();
  /// Completes the package, and gives up what could not be written.
  void finish();
  void say(const std::string& line) const;

  const LiveRecorderOptions options_;
  Segmenter segmenter_;
  LiveHello hello_;
  bool greeted_ = false;
  std::optional<RecordedPackage> package_;
  std::deque<LiveSegment> waiting_;  ///< to be written, oldest first
  std::uint64_t waiting_bytes_ = 0;
  struct Sound {
    LiveSound sound;
    LiveMessage message;  ///< that has its packet
  };
  std::deque<Sound> sounds_;       ///< that belong to the segments to come
  bool stopped_ = false;           ///< the oldest of them could not be written
  std::string trouble_;            ///< why the package could not be completed; said already
  std::uint64_t lost_frames_ = 0;  ///< since the recording stopped
};

}  // namespace pointreel
