#include "server/relay/segmenter.h"

#include <algorithm>
#include <utility>

#include "codec/core/reel_rules.h"
#include "codec/package/layer_file_name.h"

namespace pointreel {
namespace {

/// The cube of a segment to which a frame with this cube is added.
Cube joined_cube(const LiveSegment& segment, const Cube& cube) {
  if (segment.entry.times_us.empty() || cube == segment.entry.cube) return cube;
  Box box = segment.cubes;
  box.grow(box_of(cube));
  return bounding_cube(box);
}

}  // namespace

void Segmenter::begin(const LiveHello& hello) {
  if (hello.session != hello_.session) {
    frames_ = 0;
    last_us_ = 0;
    shift_us_ = 0;
  }
  hello_ = hello;
  end_frame();
}

void Segmenter::end_frame() {
  if (frame_ && next_layer_ < expected_layers_) segment_.partial = true;
  frame_.reset();
}

/// Publishers' times rise steadily. If one's clock was set back nevertheless, its frames continue
/// after those before, at the nominal rate.
std::uint64_t Segmenter::time_of(const LiveLayer& layer) const {
  std::uint64_t time = layer.capture_us + shift_us_;
  if (frames_ > 0 && time <= last_us_) time = last_us_ + frame_duration_us(hello_.fps);
  return std::min(time, kMaxCaptureTime);
}

/// Whether the frame that begins with this layer belongs to the next segment.
bool Segmenter::ends_before(const LiveLayer& layer, const FrameHeader& header) const {
  const Segment& entry = segment_.entry;
  if (entry.times_us.empty()) return false;
  return time_of(layer) >= entry.times_us.front() + segment_us_ ||
         bytes_ + layer.bytes.size() > segment_bytes_ || entry.times_us.size() >= kMaxFrames ||
         !check_cube(joined_cube(segment_, header.cube));
}

std::optional<LiveSegment> Segmenter::add(const LiveLayer& layer) {
  std::optional<LiveSegment> finished;
  if (!check_chunks(hello_, layer.layer, layer.sizes, true)) return finished;
  if (layer.layer == 0) {
    end_frame();
    const auto parsed = read_frame_header(layer.bytes.first(layer.sizes.geometry));
    if (!parsed || name(parsed->header.codec) != hello_.codec) return finished;
    if (!check_cube(parsed->header.cube) || layer.layers > hello_.layer_names.size()) {
      return finished;
    }
    if (ends_before(layer, parsed->header)) finished = flush();
    begin_frame(layer, parsed->header);
  }
  if (frame_ != layer.frame || layer.layer != next_layer_) return finished;
  ++next_layer_;
  segment_.entry.layers[layer.layer].frames.back() = layer.sizes;
  segment_.files[layer.layer].append(reinterpret_cast<const char*>(layer.bytes.data()),
                                     layer.bytes.size());
  bytes_ += layer.bytes.size();
  return finished;
}

/// Adds a frame without any layers.
void Segmenter::begin_frame(const LiveLayer& layer, const FrameHeader& header) {
  Segment& entry = segment_.entry;
  if (entry.times_us.empty()) {
    entry.first_frame = frames_;
    entry.layers.resize(hello_.layer_names.size());
    segment_.files.resize(hello_.layer_names.size());
    segment_.depth_min = header.depth;
  }
  entry.cube = joined_cube(segment_, header.cube);
  segment_.cubes.grow(box_of(header.cube));
  last_us_ = time_of(layer);
  shift_us_ = last_us_ > layer.capture_us ? last_us_ - layer.capture_us : 0;
  frame_ = layer.frame;
  next_layer_ = 0;
  ++frames_;
  // Scalar fields have a layer that the frame's header does not count.
  expected_layers_ = std::max(header.layers, layer.layers);
  entry.times_us.push_back(last_us_);
  entry.points.push_back(header.source_points);
  for (LayerFile& file : entry.layers) file.frames.emplace_back();
  segment_.depth_min = std::min<std::uint32_t>(segment_.depth_min, header.depth);
  segment_.depth_max = std::max<std::uint32_t>(segment_.depth_max, header.depth);
  segment_.any_point = segment_.any_point || header.source_points > 0;
}

std::optional<LiveSegment> Segmenter::flush() {
  end_frame();
  if (segment_.entry.times_us.empty()) return std::nullopt;
  LiveSegment finished = std::exchange(segment_, {});
  bytes_ = 0;
  for (std::size_t i = 0; i < finished.files.size(); ++i) {
    finished.files[i].shrink_to_fit();  // it may be kept for long
    finished.entry.layers[i].bytes = finished.files[i].size();
    finished.entry.layers[i].checksum =
        checksum_of({reinterpret_cast<const std::uint8_t*>(finished.files[i].data()),
                     finished.files[i].size()});
  }
  return finished;
}

void name_files(LiveSegment& segment, const std::vector<std::string>& layers) {
  for (std::size_t i = 0; i < layers.size(); ++i) {
    LayerFile& file = segment.entry.layers[i];
    file.path = layer_file_name(segment.entry.first_frame, layers[i], file.checksum);
  }
}

void LiveTotals::add(const LiveSegment& segment) {
  depth_min = any_frame ? std::min(depth_min, segment.depth_min) : segment.depth_min;
  depth_max = std::max(depth_max, segment.depth_max);
  any_frame = true;
  any_point = any_point || segment.any_point;
  partial = partial || segment.partial;
  cubes.grow(segment.cubes);
}

Manifest live_head(const LiveHello& hello, const LiveTotals& totals) {
  Manifest manifest;
  static_cast<ReelHead&>(manifest) = hello;
  manifest.depth_min = totals.depth_min;
  manifest.depth_max = totals.depth_max;
  manifest.partial = totals.partial;
  // A publisher may leave out the bounds even though there are points.
  if (totals.any_point) manifest.bounds = hello.bounds.empty() ? totals.cubes : hello.bounds;
  return manifest;
}

Segment rebased(Segment segment, std::uint32_t first_frame, std::uint64_t start_us) {
  segment.first_frame -= first_frame;
  for (std::uint64_t& time : segment.times_us) time -= start_us;
  return segment;
}

std::uint64_t end_of(const Segment& segment, double fps) {
  return segment.times_us.back() + frame_duration_us(fps);
}

bool go_together(const LiveHello& a, const LiveHello& b) {
  return a.session == b.session && a.codec == b.codec && a.entropy == b.entropy && a.up == b.up &&
         a.layer_names == b.layer_names;
}

}  // namespace pointreel
