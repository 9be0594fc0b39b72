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
/// again, for viewers that have read an older manifest. The last manifest of a session stays, with
/// its files, until the next session has a segment. See PROTOCOL.md, "Live over HTTP".
class HttpWindow : public LiveSink {
 public:
  HttpWindow(WindowOutput output, const WindowOptions& options = {})
      : output_(std::move(output)), options_(options), segmenter_(options.segment_us) {}
  ~HttpWindow() override;

  void hello(const LiveHello& hello) override;
  void layer(const LiveLayer& layer, const LiveMessage& message) override;
  void sound(const LiveSound& sound, const LiveMessage& message) override;
  void end() override;

 private:
  /// A segment that has left the manifest.
  struct Old {
    LiveSegment segment;
    std::uint64_t until;  ///< its files go when this many segments were appended
  };

  void append(LiveSegment segment);
  /// Takes the oldest segments out of the manifest.
  void retire(std::size_t count);
  void write_manifest_file();
  void remove_old();
  /// Two sessions that begin alike have files of the same name and content.
  bool is_kept(const std::string& path) const;

  const WindowOutput output_;
  const WindowOptions options_;
  Segmenter segmenter_;
  LiveHello hello_;
  bool greeted_ = false, ended_ = false;
  // Both without their bytes, oldest first.
  std::deque<LiveSegment> segments_;  ///< in the manifest
  std::deque<Old> old_;
  std::uint64_t appended_ = 0;
  std::string sound_;  ///< what came since the newest segment, as a file
};

}  // namespace pointreel
