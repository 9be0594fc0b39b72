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

/// The threads that fill a FrameBuffer: some fetch what it wants, others make that ready to draw. A
/// damaged layer is fetched once more; if it is damaged again, the frame is shown without that
/// layer and all finer ones. Runs from construction to destruction.
class Pipeline {
 public:
  /// Makes a fetched frame ready to draw. Called by several threads at once, in a TBB arena with a
  /// slot for each: while fewer frames are being prepared, parts of a frame may use the free slots.
  using Prepare = std::function<Result<SceneFrame>(const FrameRequest&, const FetchedFrame&)>;
  /// Called for each layer that could not be fetched or prepared, by the thread that tried.
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

  /// How many layers, or whole frames, could not be fetched or prepared so far.
  std::uint64_t errors() const { return errors_; }
  std::uint64_t refetched() const { return refetched_; }  ///< layers that came damaged
  std::uint64_t fetched_bytes() const { return fetched_bytes_; }

 private:
  void end();
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
  std::vector<std::jthread> fetch_threads_, prepare_threads_;
};

}  // namespace pointreel
