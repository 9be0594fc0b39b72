#include "client/playback/pipeline.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <utility>

#include <tbb/info.h>

namespace pointreel {

namespace {

/// A place for each thread. TBB has workers for all processors but one: what is more is kept free
/// of them.
tbb::task_arena arena_for(int threads) {
  return tbb::task_arena(threads, std::max(1, threads - tbb::info::default_concurrency() + 1));
}

}  // namespace

Pipeline::Pipeline(Source& source, FrameBuffer& buffer, Parts parts, Prepare prepare,
                   OnError on_error, const Options& options)
    : source_(source),
      buffer_(buffer),
      parts_(std::move(parts)),
      prepare_(std::move(prepare)),
      on_error_(std::move(on_error)),
      fetched_(std::max(1u, options.prepare_threads)),
      arena_(arena_for(static_cast<int>(std::max(1u, options.prepare_threads)))) {
  for (unsigned i = 0; i < std::max(1u, options.fetch_threads); ++i)
    fetch_threads_.emplace_back([this] { fetch_frames(); });
  for (unsigned i = 0; i < std::max(1u, options.prepare_threads); ++i)
    prepare_threads_.emplace_back([this] { prepare_frames(); });
}

Pipeline::~Pipeline() {
  ending_ = true;
  buffer_.close();
  source_.cancel();
  fetched_.close();
  for (std::thread& thread : fetch_threads_) thread.join();
  for (std::thread& thread : prepare_threads_) thread.join();
}

void Pipeline::report(const FrameRequest& request, const Error& error) {
  if (ending_) return;  // a fetch that was cancelled is no error
  ++errors_;
  on_error_(request.frame, error);
}

void Pipeline::fetch_frames() {
  while (const auto request = buffer_.next_wanted()) {
    const auto start = std::chrono::steady_clock::now();
    auto frame = source_.fetch(request->frame, parts_(*request));
    const double ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    if (!frame) {
      report(*request, frame.error());
      buffer_.fail(*request);
    } else if (!buffer_.wanted(*request) ||
               !fetched_.push(Fetched{*request, std::move(*frame), ms})) {
      buffer_.abandon(*request);
    }
  }
}

void Pipeline::prepare_frames() {
  while (const auto item = fetched_.pop()) {
    // What nobody waits for is not worth the time; nor is a late frame when a newer one is here.
    if (!buffer_.wanted(item->request) || (buffer_.late(item->request) && fetched_.size() > 0)) {
      buffer_.abandon(item->request);
      continue;
    }
    auto frame = arena_.execute([&] { return prepare_(item->request, item->frame); });
    if (frame) {
      frame->fetch_ms = item->fetch_ms;
      frame->fetched_bytes = item->frame.size();
      buffer_.deliver(item->request, std::make_shared<const SceneFrame>(std::move(*frame)));
    } else {
      report(item->request, frame.error());
      buffer_.fail(item->request);
    }
  }
}

}  // namespace pointreel
