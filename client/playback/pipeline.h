#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <thread>
#include <vector>

#include <tbb/task_arena.h>

#include "client/playback/buffer.h"
#include "client/source/source.h"

namespace pointreel {

/// The threads that fill a FrameBuffer: some fetch what it wants, some turn that into frames ready
/// to draw. What came damaged is fetched once more, and then the frame is shown without that layer
/// and those after it. Runs from its construction to its destruction.
class Pipeline {
 public:
  /// Makes a fetched frame ready to draw. Called by several threads at once, in a TBB arena with a
  /// place for each: while fewer frames are prepared, parts of a frame may take those left.
  using Prepare = std::function<Result<SceneFrame>(const FrameRequest&, const FetchedFrame&)>;
  /// Told of each layer that could not be fetched or prepared, on the thread that found it.
  using OnError = std::function<void(std::uint32_t frame, const Error&)>;

  struct Options {
    unsigned fetch_threads = 2;
    unsigned prepare_threads = 2;
  };

  /// `source` and `buffer` outlive the pipeline. The reel has at least one frame.
  Pipeline(Source& source, FrameBuffer& buffer, Prepare prepare, OnError on_error,
           const Options& options);
  /// Closes the buffer, cancels the source's fetches, and waits for the threads.
  ~Pipeline();
  Pipeline(const Pipeline&) = delete;
  Pipeline& operator=(const Pipeline&) = delete;

  /// Layers, or whole frames, that could not be fetched or prepared so far.
  std::uint64_t errors() const { return errors_; }
  std::uint64_t refetched() const { return refetched_; }  ///< that came damaged
  std::uint64_t fetched_bytes() const { return fetched_bytes_; }

 private:
  void fetch_frames();
  void prepare_frames();
  Result<SceneFrame> prepare(const FrameRequest& request, const FetchedFrame& fetched);
  void prepare_frame_of(FrameRequest& request);
  std::uint32_t find_broken_layer(const FrameRequest& request);
  void report(std::uint32_t frame, const Error& error);

  Source& source_;
  FrameBuffer& buffer_;
  const Prepare prepare_;
  const OnError on_error_;
  tbb::task_arena arena_;
  std::atomic<std::uint64_t> errors_{0}, refetched_{0}, fetched_bytes_{0};
  std::atomic<bool> ending_{false};
  std::vector<std::thread> fetch_threads_, prepare_threads_;
};

}  // namespace pointreel
