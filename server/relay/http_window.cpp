#include "server/relay/http_window.h"

#include <algorithm>
#include <utility>

#include "codec/live/live_sound.h"
#include "codec/package/layer_file_name.h"
#include "codec/package/manifest.h"

namespace pointreel {
namespace {

std::uint64_t bytes_of(const LiveSegment& segment) {
  std::uint64_t bytes = 0;
  for (const PackageFile* file : segment.entry.files()) bytes += file->bytes;
  return bytes;
}

std::uint64_t bytes_of(const std::deque<LiveSegment>& segments) {
  std::uint64_t bytes = 0;
  for (const LiveSegment& segment : segments) bytes += bytes_of(segment);
  return bytes;
}

bool names(const LiveSegment& segment, const std::string& path) {
  return std::ranges::any_of(segment.entry.files(),
                             [&](const PackageFile* file) { return file->path == path; });
}

}  // namespace

HttpWindow::~HttpWindow() {
  output_.remove(kManifestName);
  retire(segments_.size());
  for (const Old& old : old_)
    for (const PackageFile* file : old.segment.entry.files()) output_.remove(file->path);
}

void HttpWindow::hello(const LiveHello& hello) {
  if (greeted_ && !go_together(hello_, hello)) {
    segmenter_.flush();
    retire(segments_.size());  // the manifest names them until there is one of the new session
    sound_.clear();
  }
  segmenter_.begin(hello);
  hello_ = hello;
  greeted_ = true;
  ended_ = false;
}

void HttpWindow::layer(const LiveLayer& layer, const LiveMessage&) {
  if (auto segment = segmenter_.add(layer)) append(std::move(*segment));
}

void HttpWindow::sound(const LiveSound&, const LiveMessage& message) {
  // While no segment ends, sound has no pictures to be heard with.
  if (sound_.size() + message.bytes->size() + 2 > kMaxSegmentSoundBytes) sound_.clear();
  append_live_sound(sound_, *message.bytes);
}

void HttpWindow::end() {
  ended_ = true;
  if (auto segment = segmenter_.flush()) {
    append(std::move(*segment));
  } else if (!segments_.empty()) {
    write_manifest_file();
  }
}

void HttpWindow::append(LiveSegment segment) {
  name_files(segment, hello_.layer_names);
  for (std::size_t i = 0; i < segment.files.size(); ++i) {
    output_.put(segment.entry.layers[i].path, std::move(segment.files[i]), true);
  }
  segment.files.clear();
  if (!sound_.empty()) {
    const std::uint64_t checksum =
        checksum_of({reinterpret_cast<const std::uint8_t*>(sound_.data()), sound_.size()});
    segment.entry.sound = PackageFile{layer_file_name(segment.entry.first_frame, "sound", checksum),
                                      sound_.size(), checksum};
    output_.put(segment.entry.sound->path, std::exchange(sound_, {}), true);
  }
  segments_.push_back(std::move(segment));
  ++appended_;
  while (segments_.size() > 1 &&
         (segments_.size() > options_.segments || bytes_of(segments_) > options_.bytes)) {
    retire(1);
  }
  write_manifest_file();
  remove_old();
}

void HttpWindow::retire(std::size_t count) {
  const std::uint64_t until = appended_ + options_.segments;
  for (; count > 0; --count) {
    old_.push_back({std::move(segments_.front()), until});
    segments_.pop_front();
  }
}

void HttpWindow::remove_old() {
  std::uint64_t bytes = 0;
  for (const Old& old : old_) bytes += bytes_of(old.segment);
  while (!old_.empty() && (old_.front().until <= appended_ ||
                           (bytes > options_.bytes && old_.size() > segments_.size()))) {
    const LiveSegment segment = std::move(old_.front().segment);
    old_.pop_front();
    bytes -= bytes_of(segment);
    for (const PackageFile* file : segment.entry.files())
      if (!is_kept(file->path)) output_.remove(file->path);
  }
}

bool HttpWindow::is_kept(const std::string& path) const {
  return std::any_of(old_.begin(), old_.end(),
                     [&](const Old& old) { return names(old.segment, path); }) ||
         std::any_of(segments_.begin(), segments_.end(),
                     [&](const LiveSegment& segment) { return names(segment, path); });
}

void HttpWindow::write_manifest_file() {
  LiveTotals totals;
  for (const LiveSegment& segment : segments_) totals.add(segment);
  Manifest manifest = live_head(hello_, totals);
  const Segment& first = segments_.front().entry;
  manifest.live = LiveManifest{hello_.session, first.first_frame, first.times_us.front(), ended_};
  for (const LiveSegment& segment : segments_) {
    manifest.segments.push_back(
        rebased(segment.entry, manifest.live->first_frame, manifest.live->start_us));
  }
  manifest.duration_us = end_of(manifest.segments.back(), hello_.fps);
  output_.put(kManifestName, write_manifest(manifest), false);
}

}  // namespace pointreel
