#include "server/relay/recorder.h"

#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "common/base/try.h"

namespace pointreel {
namespace fs = std::filesystem;
namespace {

std::uint64_t bytes_of_files(const LiveSegment& segment) {
  std::uint64_t bytes = 0;
  for (const std::string& file : segment.files) bytes += file.size();
  return bytes;
}

}  // namespace

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

void LiveRecorder::sound(const LiveSound& sound, const LiveMessage& message) {
  // Half a minute, while nothing can be written.
  constexpr std::size_t kMost = 1500;
  if (sounds_.size() == kMost) sounds_.pop_front();
  sounds_.push_back({sound, message});
}

void LiveRecorder::write_sound() {
  for (const Sound& sound : sounds_) package_->add(sound.sound);
  sounds_.clear();
}

void LiveRecorder::end() {
  if (auto segment = segmenter_.flush()) append(std::move(*segment));
  if (!waiting_.empty()) {
    std::uint64_t frames = 0;
    for (const LiveSegment& segment : waiting_) frames += segment.entry.frame_count();
    say(fmt::format("recording {}: the last {} frames wait until they can be written",
                    options_.name, frames));
  }
  pause();
}

bool LiveRecorder::settle() {
  if (!waiting_.empty()) write_waiting();
  return waiting_.empty() && pause();
}

bool LiveRecorder::pause() {
  if (!package_) return true;
  write_sound();
  const auto completed = package_->complete(hello_);
  const std::string trouble = completed ? "" : completed.error().message;
  if (!completed && trouble != trouble_) say(trouble);
  trouble_ = trouble;
  return completed.has_value();
}

void LiveRecorder::append(LiveSegment segment) {
  waiting_bytes_ += bytes_of_files(segment);
  waiting_.push_back(std::move(segment));
  write_waiting();
  for (; waiting_bytes_ > options_.waiting_bytes; waiting_.pop_front()) {
    waiting_bytes_ -= bytes_of_files(waiting_.front());
    lost_frames_ += waiting_.front().entry.frame_count();
  }
}

void LiveRecorder::write_waiting() {
  for (; !waiting_.empty(); waiting_.pop_front()) {
    if (package_ && package_->manifest_bytes() > options_.manifest_bytes) complete();
    if (const auto recorded = record(waiting_.front()); !recorded) {
      if (!std::exchange(stopped_, true)) {
        say(fmt::format("{}; recording {} has stopped until that is possible",
                        recorded.error().message, options_.name));
      }
      return;
    }
    waiting_bytes_ -= bytes_of_files(waiting_.front());
    write_sound();
  }
  if (std::exchange(stopped_, false)) {
    say(fmt::format("recording {} continues; {} frames are lost", options_.name,
                    std::exchange(lost_frames_, 0)));
  }
}

Result<void> LiveRecorder::record(LiveSegment& segment) {
  // Someone may have moved or removed it, or changed it while the publisher was away.
  if (package_ && !package_->take_back()) package_.reset();
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

void LiveRecorder::complete() {
  if (!package_) return;
  if (const auto completed = package_->complete(hello_); !completed) {
    say(completed.error().message);
  }
  package_.reset();
}

void LiveRecorder::finish() {
  write_waiting();
  if (package_) write_sound();
  sounds_.clear();
  complete();
  for (const LiveSegment& segment : waiting_) lost_frames_ += segment.entry.frame_count();
  waiting_.clear();
  waiting_bytes_ = 0;
  if (std::exchange(stopped_, false)) {
    say(fmt::format("recording {} has ended; its last {} frames are lost", options_.name,
                    std::exchange(lost_frames_, 0)));
  }
}

void LiveRecorder::say(const std::string& line) const {
  if (options_.say) options_.say(line);
}

}  // namespace pointreel
