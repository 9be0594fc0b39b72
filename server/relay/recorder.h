#pragma once

#include <cstdint>
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
  /// Called with one line if something goes wrong, and when that is over. May be empty.
  std::function<void(const std::string& line)> say;
};

/// Records a stream into packages: FOLDER/NAME, and then NAME-2 and so on for each new session and
/// whenever a manifest gets too long. Existing files and folders are never touched.
///
/// While nothing can be written, for instance because the disk is full, segments are lost. The
/// recording continues in the same package with the first segment that can be written.
class LiveRecorder : public LiveSink {
 public:
  explicit LiveRecorder(LiveRecorderOptions options);
  ~LiveRecorder() override;

  void hello(const LiveHello& hello) override;
  void layer(const LiveLayer& layer, const LiveMessage& message) override;
  void end() override;

 private:
  void append(LiveSegment segment);
  Result<void> record(LiveSegment& segment);
  Result<void> open(const LiveSegment& first);
  /// Ends the package, so that the next segment begins another one.
  void finish();
  void say(const std::string& line) const;

  const LiveRecorderOptions options_;
  Segmenter segmenter_;
  LiveHello hello_;
  bool greeted_ = false;
  std::optional<RecordedPackage> package_;
  std::uint64_t lost_frames_ = 0;  ///< since a segment was recorded
};

}  // namespace pointreel
