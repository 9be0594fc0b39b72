#include "client/playback/pipeline.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <utility>

#include <tbb/info.h>

#include "common/threads/without_exceptions.h"

namespace pointreel {

namespace {

/// An arena with a slot for each thread. TBB has workers for all processors but one, so that slots
/// beyond those are reserved for the threads.
tbb::task_arena arena_for(int threads) {
  return tbb::task_arena(threads, std::max(1, threads - tbb::info::default_concurrency() + 1));
}

}  // namespace

Pipeline::Pipeline(Source& source, FrameBuffer& buffer, Prepare prepare, OnError on_error,
                   const Options& options)
    : source_(source),
      buffer_(buffer),
      prepare_(std::move(prepare)),
      on_error_(std::move(on_error)),
      arena_(arena_for(static_cast<int>(std::max(1u, options.prepare_threads)))) {
  try {
    for (unsigned i = 0; i < std::max(1u, options.fetch_threads); ++i)
      fetch_threads_.emplace_back([this] { fetch_frames(); });
    for (unsigned i = 0; i < std::max(1u, options.prepare_threads); ++i)
      prepare_threads_.emplace_back([this] { prepare_frames(); });
  } catch (...) {
    end();  // the threads that there are must not wait for frames any more
    throw;
  }
}

Pipeline::~Pipeline() { end(); }

void Pipeline::end() {
  ending_ = true;
  buffer_.close();
  source_.cancel();
}

void Pipeline::report(std::uint32_t frame, const Error& error) {
  ++errors_;
  on_error_(frame, error);
}

void Pipeline::fetch_frames() {
  while (const auto request = buffer_.next_fetch()) {
    const auto start = std::chrono::steady_clock::now();
    auto frame = without_exceptions([&] { return source_.fetch(*request); });
    const double ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    if (frame) {
      fetched_bytes_ += frame->size();
      buffer_.fetched(*request, std::move(*frame), ms);
    } else if (ending_ || request->stop.stop_requested()) {
      buffer_.fetch_stopped(*request);  // that is not an error
    } else {
      report(request->frame, frame.error());
      buffer_.fetch_failed(*request);
    }
  }
}

Result<SceneFrame> Pipeline::prepare(const FrameRequest& request, const FetchedFrame& fetched) {
  return without_exceptions(
      [&] { return arena_.execute([&] { return prepare_(request, fetched); }); });
}

void Pipeline::prepare_frames() {
  while (auto request = buffer_.next_wanted()) prepare_frame_of(*request);
}

void Pipeline::prepare_frame_of(FrameRequest& request) {
  auto frame = prepare(request, request.fetched);
  if (frame) {
    frame->fetch_ms = request.fetch_ms;
    buffer_.deliver(request, std::make_shared<const SceneFrame>(std::move(*frame)));
    return;
  }
  const std::uint32_t layer = find_broken_layer(request);
  if (request.stop.stop_requested())
    buffer_.make_stopped(request);  // that is not an error
  else if (buffer_.broken(request, layer))
    ++refetched_;
  else
    report(request.frame, frame.error());
}

/// The first layer with which the frame does not decode.
std::uint32_t Pipeline::find_broken_layer(const FrameRequest& request) {
  FetchedFrame prefix;
  prefix.tables = request.fetched.tables;
  for (const FetchedLayer& layer : request.fetched.layers) {
    if (prefix.layers.size() + 1 == request.fetched.layers.size()) break;
    prefix.layers.push_back(layer);
    if (!prepare(request, prefix)) return static_cast<std::uint32_t>(prefix.layers.size() - 1);
  }
  return static_cast<std::uint32_t>(prefix.layers.size());
}

}  // namespace pointreel
