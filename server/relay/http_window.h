#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <string>

#include "server/relay/relay.h"
#include "server/relay/segmenter.h"

namespace pointreel {

/// Where a stream's files for viewers over HTTP go: under the stream's path, any thread may ask for
/// them.
struct WindowOutput {
  std::function<void(const std::string& name, std::string content, bool immutable)> put;
  std::function<void(const std::string& name)> remove;
};

struct WindowOptions {
  std::uint64_t segment_us = 500'000;  ///< of one segment
  std::size_t segments = 20;           ///< that the manifest has
  std::uint64_t bytes = 64u << 20;     ///< of all of them; there are fewer where that is too little
};

/// Live over HTTP: the newest segments of a stream in memory, as a package whose reel.json is
/// replaced with each segment. Segments that are in the manifest no longer stay for as long again,
/// for whoever has read an older one. PROTOCOL.md, "Live over HTTP".
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
  /// Without their bytes, oldest first: those of the manifest, and those before it.
  std::deque<LiveSegment> segments_, old_;
};

}  // namespace pointreel
