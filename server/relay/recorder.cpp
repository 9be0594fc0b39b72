#include "server/relay/recorder.h"

#include <fstream>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "common/base/try.h"
#include "common/stream/manifest.h"

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
    given_up_ = false;
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
  if (package_.empty()) return;
  if (const auto written = write_manifest_file(false); !written) failed(written.error());
}

void LiveRecorder::append(LiveSegment segment) {
  if (given_up_) return;
  if (lines_bytes_ > options_.manifest_bytes) finish();
  if (package_.empty()) {
    if (const auto opened = open(); !opened) {
      failed(opened.error());
      return;
    }
    first_frame_ = segment.entry.first_frame;
    start_us_ = segment.entry.times_us.front();
  }
  if (const auto written = write(segment); !written) failed(written.error());
}

Result<void> LiveRecorder::open() {
  std::error_code error;
  fs::create_directories(options_.folder, error);
  for (int i = 1; !error && i < 100'000; ++i) {
    const fs::path package =
        options_.folder / (i == 1 ? options_.name : fmt::format("{}-{}", options_.name, i));
    if (fs::create_directory(package, error)) {
      package_ = package;
      return {};
    }
  }
  return fail(ErrorCode::io,
              fmt::format("{}: cannot create a folder here: {}", options_.folder.string(),
                          error ? error.message() : "there are too many recordings"));
}

Result<void> LiveRecorder::write(LiveSegment& segment) {
  segment.entry = rebased(std::move(segment.entry), first_frame_, start_us_);
  name_files(segment, hello_.layer_names);
  for (std::size_t i = 0; i < segment.files.size(); ++i) {
    TRY(write_file(segment.entry.layers[i].path, segment.files[i]));
  }
  totals_.add(segment);
  duration_us_ = end_of(segment.entry, hello_.fps);
  lines_.push_back(write_segment(segment.entry));
  lines_bytes_ += lines_.back().size();
  return write_manifest_file(true);
}

Result<void> LiveRecorder::write_file(const std::string& name, std::string_view content) const {
  // Readers ignore files of this name.
  const fs::path unfinished = package_ / ".unfinished";
  std::ofstream out(unfinished, std::ios::binary | std::ios::trunc);
  out.write(content.data(), static_cast<std::streamsize>(content.size()));
  out.close();
  std::error_code error;
  if (out) fs::rename(unfinished, package_ / name, error);
  if (!out || error) {
    return fail(ErrorCode::io, fmt::format("{}: cannot be written; check that the disk is not full",
                                           (package_ / name).string()));
  }
  return {};
}

Result<void> LiveRecorder::write_manifest_file(bool growing) const {
  Manifest manifest = live_head(hello_, totals_);
  manifest.duration_us = duration_us_;
  if (growing) manifest.live = LiveManifest{hello_.session, first_frame_, start_us_, false};
  return write_file(kManifestName, write_manifest(manifest, lines_));
}

void LiveRecorder::finish() {
  if (!package_.empty() && !lines_.empty()) {
    if (const auto written = write_manifest_file(false); !written) failed(written.error());
  }
  package_.clear();
  totals_ = {};
  lines_.clear();
  lines_bytes_ = 0;
}

void LiveRecorder::failed(const Error& error) {
  if (!given_up_ && options_.say) {
    options_.say(error.message + "; recording " + options_.name + " has stopped");
  }
  given_up_ = true;
}

}  // namespace pointreel
