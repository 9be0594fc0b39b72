#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "pointreel/error.h"
#include "server/relay/relay.h"
#include "server/relay/segmenter.h"

namespace pointreel {

struct LiveRecorderOptions {
  std::filesystem::path folder;  ///< in which packages are created
  std::string name;              ///< of the stream and of its first package
  std::uint64_t segment_us = 1'000'000;
  /// If the manifest gets longer than this, the recording continues in another package.
  std::size_t manifest_bytes = 8u << 20;
  /// Called with one line if something goes wrong. May be empty.
  std::function<void(const std::string& line)> say;
};

/// Records a stream into packages: FOLDER/NAME, and then NAME-2 and so on for each new session and
/// whenever a manifest gets too long. Existing files and folders are never touched.
///
/// At any moment, however the process ends, the folder on disk is a package of all complete
/// segments: files get their names when they are complete, and reel.json is replaced after that.
/// While the package grows, reel.json has the member `live`.
class LiveRecorder : public LiveSink {
 public:
  explicit LiveRecorder(LiveRecorderOptions options);
  ~LiveRecorder() override;

  void hello(const LiveHello& hello) override;
  void layer(const LiveLayer& layer, const LiveMessage& message) override;
  void end() override;

 private:
  void append(LiveSegment segment);
  Result<void> open();
  Result<void> write(LiveSegment& segment);
  Result<void> write_file(const std::string& name, std::string_view content) const;
  Result<void> write_manifest_file(bool growing) const;
  /// Ends the package, so that the next segment begins another one.
  void finish();
  void failed(const Error& error);

  const LiveRecorderOptions options_;
  Segmenter segmenter_;
  LiveHello hello_;
  bool greeted_ = false;
  bool given_up_ = false;          ///< writing has failed: the rest of the session is not recorded
  std::filesystem::path package_;  ///< empty if none is open
  LiveTotals totals_;
  std::vector<std::string> lines_;  ///< lines of the manifest, one for each segment
  std::size_t lines_bytes_ = 0;
  std::uint32_t first_frame_ = 0;
  std::uint64_t start_us_ = 0, duration_us_ = 0;
};

}  // namespace pointreel
