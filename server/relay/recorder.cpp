#include "server/relay/recorder.h"

#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "common/base/try.h"

namespace pointreel {
namespace fs = std::filesystem;

LiveRecorder::LiveRecorder(LiveRecorderOptions options)
    : options_(std::move(options)), segmenter_(options_.segment_us) {}

LiveRecorder::~LiveRecorder() {
  if (auto segment = segmenter_.flush()) append(std::move(*segment));
  finish();
}

void LiveRecorder::hello(const LiveHello& hello) {
  if (greeted_ && !go_together(hello_, hello)) {
    if (auto segment = segmenter_.flush()) append(std::move(*segment));
    finish();
  }
  segmenter_.begin(hello);
  hello_ = hello;
  greeted_ = true;
}

void LiveRecorder::layer(const LiveLayer& layer, const LiveMessage&) {
  if (auto segment = segmenter_.add(layer)) append(std::move(*segment));
}

void LiveRecorder::end() {
  if (auto segment = segmenter_.flush()) append(std::move(*segment));
  // The package is complete, unless the publisher comes back.
  if (!package_) return;
  if (const auto completed = package_->complete(hello_); !completed) {
    say(completed.error().message);
  }
}

void LiveRecorder::append(LiveSegment segment) {
  const std::uint32_t frames = segment.entry.frame_count();
  if (package_ && package_->manifest_bytes() > options_.manifest_bytes) finish();
  if (const auto recorded = record(segment); !recorded) {
    if (lost_frames_ == 0) {
      say(fmt::format("{}; recording {} has stopped until that is possible",
                      recorded.error().message, options_.name));
    }
    lost_frames_ += frames;
  } else if (lost_frames_ > 0) {
    say(fmt::format("recording {} continues; {} frames before are lost", options_.name,
                    std::exchange(lost_frames_, 0)));
  }
}

Result<void> LiveRecorder::record(LiveSegment& segment) {
  // Someone may have moved or removed it.
  if (package_ && !package_->exists()) package_.reset();
  if (!package_) TRY(open(segment));
  const auto added = package_->add(segment, hello_);
  if (!added && package_->empty()) {
    package_->remove();
    package_.reset();
  }
  return added;
}

Result<void> LiveRecorder::open(const LiveSegment& first) {
  std::error_code error;
  fs::create_directories(options_.folder, error);
  for (int i = 1; !error && i < 100'000; ++i) {
    const fs::path folder =
        options_.folder / (i == 1 ? options_.name : fmt::format("{}-{}", options_.name, i));
    // Whatever has this name already, be it a file or a link that leads nowhere, the next is taken.
    if (fs::symlink_status(folder, error).type() != fs::file_type::not_found) {
      if (!error) continue;
      break;
    }
    if (fs::create_directory(folder, error)) {
      package_.emplace(folder, first.entry.first_frame, first.entry.times_us.front());
      return {};
    }
  }
  return fail(ErrorCode::io,
              fmt::format("{}: cannot create a folder here: {}", options_.folder.string(),
                          error ? error.message() : "there are too many recordings"));
}

void LiveRecorder::finish() {
  if (package_) {
    if (const auto completed = package_->complete(hello_); !completed) {
      say(completed.error().message);
    }
  }
  package_.reset();
  if (lost_frames_ > 0) {
    say(fmt::format("recording {} has ended; its last {} frames are lost", options_.name,
                    std::exchange(lost_frames_, 0)));
  }
}

void LiveRecorder::say(const std::string& line) const {
  if (options_.say) options_.say(line);
}

}  // namespace pointreel
