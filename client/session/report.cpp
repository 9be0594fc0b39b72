#include "client/session/report.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "pointreel/chunks.h"

namespace pointreel {
namespace {

/// Rounds to a microsecond: more digits are noise.
double rounded(double ms) { return std::round(ms * 1000.0) / 1000.0; }

nlohmann::ordered_json json_of(const TimeSamples& samples) {
  const TimeSummary summary = samples.summary();
  return {{"median", rounded(summary.median)},
          {"p95", rounded(summary.p95)},
          {"max", rounded(summary.max)}};
}

nlohmann::ordered_json json_of(const AudioPlayer::Statistics& audio) {
  nlohmann::ordered_json json = {{"plays", audio.plays}};
  if (!audio.error.empty()) json["error"] = audio.error;
  json["delay_ms"] = rounded(audio.delay_ms);
  json["breaks"] = audio.breaks;
  json["ahead_of_picture_ms"] = {{"mean", rounded(audio.mean_offset_ms)},
                                 {"worst", rounded(audio.worst_offset_ms)}};
  if (audio.capture_to_sound_ms) {
    json["capture_to_sound_ms"] = rounded(*audio.capture_to_sound_ms);
    json["gaps"] = audio.gaps;
  }
  return json;
}

nlohmann::ordered_json json_of(const WindowReport& window) {
  nlohmann::ordered_json json = {{"window_ms", rounded(window.window_ms)},
                                 {"first_picture_ms", rounded(window.first_picture_ms)},
                                 {"interface_ms", json_of(window.interface)},
                                 {"scrub_to_picture_ms", json_of(window.scrub_to_picture)},
                                 {"playing", window.playing},
                                 {"position_s", window.position_s},
                                 {"frame", window.frame},
                                 {"speed", rounded(window.speed)},
                                 {"loop", window.loop}};
  if (window.loop_range)
    json["loop_range_s"] = {static_cast<double>(window.loop_range->a_us) * 1e-6,
                            static_cast<double>(window.loop_range->b_us) * 1e-6};
  const Camera& camera = window.camera;
  json["camera"] = {{"target", {camera.target.x, camera.target.y, camera.target.z}},
                    {"distance", camera.distance},
                    {"yaw", camera.yaw},
                    {"pitch", camera.pitch}};
  json["flying"] = window.flying;
  json["floor"] = window.floor;
  json["shown"] = {
      {"help", window.help}, {"drawing", window.drawing}, {"statistics", window.statistics}};
  if (window.audio) {
    json["audio"] = json_of(*window.audio);
    json["audio"]["first_sound_ms"] = rounded(window.first_sound_ms);
  }
  if (!window.error.empty()) json["error"] = window.error;
  return json;
}

nlohmann::ordered_json json_of(const LayerPlan::Chosen& chosen) {
  auto attributes = nlohmann::ordered_json::array();
  if (chosen.decision.layers.colors) attributes.push_back("colors");
  if (chosen.decision.layers.normals) attributes.push_back("normals");
  return {{"from_frame", chosen.first_frame},
          {"layers", chosen.decision.layers.end},
          {"attributes", attributes},
          {"limited_by", name(chosen.decision.limit)}};
}

nlohmann::ordered_json json_of(const SourceReport& source) {
  nlohmann::ordered_json json = {{"source", source.where},
                                 {"at", {source.place.x, source.place.y, source.place.z}},
                                 {"frames_shown", source.frames_shown},
                                 {"frames_dropped", source.frames_dropped},
                                 {"errors", source.errors}};
  if (source.reel) {
    json["frames_from_cache"] = source.reel->reused;
    json["fetched_bytes"] = source.reel->fetched_bytes;
    json["refetched_layers"] = source.reel->refetched;
    json["link_mbit_per_second"] = rounded(source.reel->link_bits_per_second / 1e6);
    json["stalls"] = {{"count", source.reel->stalls},
                      {"seconds", rounded(source.reel->stalled_seconds)},
                      {"longest_seconds", rounded(source.reel->longest_stall_seconds)}};
    auto chosen = nlohmann::ordered_json::array();
    for (const LayerPlan::Chosen& choice : source.chosen) chosen.push_back(json_of(choice));
    json["chosen"] = chosen;
  }
  if (source.live) {
    json["live"] = {{"frames", source.live->frames},
                    {"skipped", source.live->skipped},
                    {"layers_dropped_by_server", source.live->dropped},
                    {"bad_messages", source.live->bad},
                    {"reconnections", source.live->reconnections},
                    {"bytes", source.live->bytes},
                    {"capture_to_picture_ms", json_of(source.delay)}};
  }
  return json;
}

}  // namespace

NotFetched not_fetched(const Manifest& manifest, const SceneFrame& frame,
                       const LayerRange& layers) {
  NotFetched rest;
  if (frame.layers == 0) return rest;
  const FrameLocation at = locate(manifest, frame.index);
  const std::vector<LayerFile>& files = manifest.segments[at.segment].layers;
  for (std::size_t layer = 0; layer < files.size(); ++layer) {
    const Chunks<std::uint32_t>& sizes = files[layer].frames[at.index];
    const bool fetched = layer < frame.layers;
    if (!fetched) rest.layers += sizes.geometry > 0;
    const bool normals = fetched && layers.normals, colors = normals || (fetched && layers.colors);
    if (layer == 0) {
      rest.normals = !normals && sizes.normals > 0;
      rest.colors = !colors && sizes.colors > 0;
    }
    rest.bytes += (fetched ? 0 : sizes.geometry) + (colors ? 0 : sizes.colors) +
                  (normals ? 0 : sizes.normals);
  }
  return rest;
}

void PlayReport::add(const SceneFrame& frame, const NotFetched& rest, const DrawStats& drawn) {
  ++frames_shown_;
  frames_reduced_ += drawn.coarsening != DraftCoarsening{};
  shown_rest_ += rest_.bytes;
  fetch_.add(frame.fetch_ms);
  decode_.add(frame.decode_ms);
  normals_.add(frame.normals_ms);
  svo_.add(frame.svo_ms);
  cut_.add(drawn.cut_ms);
  render_.add(drawn.render_ms);
  set_last(frame, rest, drawn);
}

void PlayReport::add_refined(const SceneFrame& frame, const NotFetched& rest,
                             const DrawStats& drawn) {
  ++frames_refined_;
  set_last(frame, rest, drawn);
}

void PlayReport::set_last(const SceneFrame& frame, const NotFetched& rest, const DrawStats& drawn) {
  layers_ = frame.layers;
  points_ = frame.points;
  nodes_ = frame.svo.node_count();
  leaves_ = frame.svo.leaf_count();
  depth_ = frame.svo.depth;
  rest_ = rest;
  last_ = drawn;
}

std::uint64_t PlayReport::fetched_bytes() const {
  std::uint64_t bytes = 0;
  for (const SourceReport& source : sources)
    bytes += source.reel ? source.reel->fetched_bytes : source.live ? source.live->bytes : 0;
  return bytes;
}

std::string PlayReport::to_json() const {
  nlohmann::ordered_json json;
  json["renderer"] = renderer;
  json["mode"] = name(mode);
  json["instancing"] = name(instancing);
  json["splatting"] = name(splatting);
  json["delta"] = delta;
  json["layers"] = layers_;
  json["size"] = {size.x, size.y};
  json["seconds"] = rounded(seconds);
  json["fps"] = seconds > 0.0 ? rounded(static_cast<double>(frames_shown_) / seconds) : 0.0;
  json["frames_shown"] = frames_shown_;
  json["frames_refined"] = frames_refined_;
  json["frames_reduced"] = frames_reduced_;
  json["frames_dropped"] = frames_dropped;
  json["errors"] = errors;
  json["fetched_bytes"] = fetched_bytes();
  json["fetch_ms"] = json_of(fetch_);
  json["decode_ms"] = json_of(decode_);
  json["normals_ms"] = json_of(normals_);
  json["svo_ms"] = json_of(svo_);
  json["cut_ms"] = json_of(cut_);
  json["render_ms"] = json_of(render_);
  json["points"] = points_;
  json["nodes"] = nodes_;
  json["leaves"] = leaves_;
  json["depth"] = depth_;
  json["drawn"] = last_.drawn;
  auto attributes = nlohmann::ordered_json::array();
  if (rest_.colors) attributes.push_back("colors");
  if (rest_.normals) attributes.push_back("normals");
  json["skipped"] = {{"layers", rest_.layers},
                     {"levels", std::max(0, finest_level - depth_)},
                     {"attributes", attributes},
                     {"bytes", shown_rest_ + rest_.bytes},
                     {"out_of_view", last_.out_of_view},
                     {"below_pixel", last_.below_pixel},
                     {"hidden", last_.hidden}};
  auto each = nlohmann::ordered_json::array();
  for (const SourceReport& source : sources) each.push_back(json_of(source));
  json["sources"] = each;
  if (window) json["window"] = json_of(*window);
  return json.dump(2, ' ', true, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace pointreel
