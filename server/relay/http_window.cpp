#include "server/relay/http_window.h"

#include <cmath>
#include <utility>

#include "common/stream/manifest.h"

namespace pointreel {
namespace {

std::uint64_t bytes_of(const LiveSegment& segment) {
  std::uint64_t bytes = 0;
  for (const LayerFile& file : segment.entry.layers) bytes += file.bytes;
  return bytes;
}

}  // namespace

HttpWindow::~HttpWindow() {
  clear();
  output_.remove(kManifestName);
}

void HttpWindow::hello(const LiveHello& hello) {
  if (greeted_ && !go_together(hello_, hello)) {
    segmenter_.flush();
    clear();
  }
  segmenter_.begin(hello);
  hello_ = hello;
  greeted_ = true;
  ended_ = false;
}

void HttpWindow::layer(const LiveLayer& layer, const LiveMessage&) {
  if (auto segment = segmenter_.add(layer)) append(std::move(*segment));
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
  segments_.push_back(std::move(segment));
  while (segments_.size() > 1 &&
         (segments_.size() > options_.segments || bytes() > options_.bytes)) {
    old_.push_back(std::move(segments_.front()));
    segments_.pop_front();
  }
  write_manifest_file();
  while (old_.size() > segments_.size()) {
    for (const LayerFile& file : old_.front().entry.layers) output_.remove(file.path);
    old_.pop_front();
  }
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

void HttpWindow::clear() {
  for (const auto* segments : {&old_, &segments_}) {
    for (const LiveSegment& segment : *segments) {
      for (const LayerFile& file : segment.entry.layers) output_.remove(file.path);
    }
  }
  old_.clear();
  segments_.clear();
}

std::uint64_t HttpWindow::bytes() const {
  std::uint64_t bytes = 0;
  for (const LiveSegment& segment : segments_) bytes += bytes_of(segment);
  return bytes;
}

}  // namespace pointreel
