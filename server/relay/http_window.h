#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <string>

#include "server/relay/relay.h"
#include "server/relay/segmenter.h"

namespace pointreel {

/// Where a stream's files are put for viewers over HTTP: under the stream's path, where any thread
/// may ask for them.
struct WindowOutput {
  std::function<void(const std::string& name, std::string content, bool immutable)> put;
  std::function<void(const std::string& name)> remove;
};

struct WindowOptions {
  std::uint64_t segment_us = 500'000;  ///< duration of a segment
  std::size_t segments = 20;           ///< in the manifest
  std::uint64_t bytes = 64u << 20;     ///< of these together; if they exceed this, there are fewer
};

/// Serves a live stream over HTTP: keeps its newest segments in memory, as a package whose
/// reel.json is replaced with each segment. Segments that have left the manifest stay for as long
/// again, for viewers that have read an older manifest. See PROTOCOL.md, "Live over HTTP".
class HttpWindow : public LiveSink {
 public:
  HttpWindow(WindowOutput output, const WindowOptions& options = {})
      : output_(std::move(output)), options_(options), segmenter_(options.segment_us) {}
  ~HttpWindow() override;

  void hello(const LiveHello& hello) override;
  void layer(const LiveLayer& layer, const LiveMessage& message) override;
  void end() override;

 private:
  void append(LiveSegment segment);
  void write_manifest_file();
  void clear();
  std::uint64_t bytes() const;

  const WindowOutput output_;
  const WindowOptions options_;
  Segmenter segmenter_;
  LiveHello hello_;
  bool greeted_ = false, ended_ = false;
  /// Without their bytes, oldest first: those in the manifest, and those that have left it.
  std::deque<LiveSegment> segments_, old_;
};

}  // namespace pointreel
