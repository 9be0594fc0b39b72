#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "pointreel/error.h"
#include "server/relay/relay.h"
#include "server/relay/segmenter.h"

namespace pointreel {

struct RecorderOptions {
  std::filesystem::path folder;  ///< that packages are made in
  std::string name;              ///< of the stream, and of the first package
  std::uint64_t segment_us = 1'000'000;
  /// A longer manifest is not written: the recording goes on in another package.
  std::size_t manifest_bytes = 8u << 20;
  /// Told what goes wrong, one line each. May be empty.
  std::function<void(const std::string& line)> say;
};

/// Records a stream into packages: FOLDER/NAME, and NAME-2 and so on for each new session, and
/// whenever a manifest becomes too long. Nothing that is there already is touched.
///
/// At any moment, whatever ends the process, what is on disk is a package of all segments that were
/// complete: files get their names when they are whole, and reel.json is replaced after them. While
/// it grows, reel.json has `live`.
class Recorder : public LiveSink {
 public:
  explicit Recorder(RecorderOptions options);
  ~Recorder() override;

  void hello(const LiveHello& hello) override;
  void layer(const LiveLayer& layer, const LiveMessage& message) override;
  void end() override;

 private:
  void append(LiveSegment segment);
  Result<void> open();
  Result<void> write(LiveSegment& segment);
  Result<void> write_file(const std::string& name, ByteView bytes) const;
  Result<void> write_manifest_file(bool growing) const;
  /// Ends the package: the next segment begins another one.
  void finish();
  void failed(const Error& error);

  const RecorderOptions options_;
  Segmenter segmenter_;
  LiveHello hello_;
  bool greeted_ = false;
  bool given_up_ = false;          ///< nothing more of this session can be written
  std::filesystem::path package_;  ///< empty: none is open
  LiveTotals totals_;
  std::vector<std::string> lines_;  ///< of the manifest, one for each segment
  std::size_t lines_bytes_ = 0;
  std::uint32_t first_frame_ = 0;
  std::uint64_t start_us_ = 0, duration_us_ = 0;
};

}  // namespace pointreel
