#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <thread>
#include <vector>

#include <tbb/task_arena.h>

#include "client/playback/buffer.h"
#include "client/source/source.h"
#include "common/base/bounded_queue.h"

namespace pointreel {

/// The threads that fill a FrameBuffer: some fetch what it wants, some turn that into frames ready
/// to draw, with a bounded queue between them. Runs from its construction to its destruction.
class Pipeline {
 public:
  /// Makes a fetched frame ready to draw. Called by several threads at once, in a TBB arena with a
  /// place for each: while fewer frames are prepared, parts of a frame may take those left.
  using Prepare = std::function<Result<SceneFrame>(const FrameRequest&, const FetchedFrame&)>;
  /// What of a frame is fetched for its mode and level.
  using Parts = std::function<FetchRequest(const FrameRequest&)>;
  /// Told of each frame that could not be fetched or prepared, on the thread that found it.
  using OnError = std::function<void(std::uint32_t frame, const Error&)>;

  struct Options {
    unsigned fetch_threads = 2;
    unsigned prepare_threads = 2;
  };

  /// `source` and `buffer` outlive the pipeline. The reel has at least one frame.
  Pipeline(Source& source, FrameBuffer& buffer, Parts parts, Prepare prepare, OnError on_error,
           const Options& options);
  /// Closes the buffer, cancels the source's fetches, and waits for the threads.
  ~Pipeline();
  Pipeline(const Pipeline&) = delete;
  Pipeline& operator=(const Pipeline&) = delete;

  /// Frames that could not be fetched or prepared so far.
  std::uint64_t errors() const { return errors_; }

 private:
  struct Fetched {
    FrameRequest request;
    FetchedFrame frame;
    double fetch_ms = 0.0;
  };

  void fetch_frames();
  void prepare_frames();
  void report(const FrameRequest& request, const Error& error);

  Source& source_;
  FrameBuffer& buffer_;
  const Parts parts_;
  const Prepare prepare_;
  const OnError on_error_;
  BoundedQueue<Fetched> fetched_;
  tbb::task_arena arena_;
  std::atomic<std::uint64_t> errors_{0};
  std::atomic<bool> ending_{false};
  std::vector<std::thread> fetch_threads_, prepare_threads_;
};

}  // namespace pointreel
