#include "client/report.h"

#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace pointreel {
namespace {

/// To a microsecond: more digits are noise.
double rounded(double ms) { return std::round(ms * 1000.0) / 1000.0; }

nlohmann::ordered_json json_of(const TimeSamples& samples) {
  const TimeSummary summary = samples.summary();
  return {{"median", rounded(summary.median)},
          {"p95", rounded(summary.p95)},
          {"max", rounded(summary.max)}};
}

}  // namespace

const char* name(DrawMode mode) {
  switch (mode) {
    case DrawMode::surfel:
      return "surfel";
    case DrawMode::voxel:
      return "voxel";
    case DrawMode::point:
      return "point";
  }
  return "";
}

void PlayReport::add(const SceneFrame& frame, const DrawStats& drawn) {
  ++frames_shown_;
  fetched_bytes_ += frame.fetched_bytes;
  fetch_.add(frame.fetch_ms);
  decode_.add(frame.decode_ms);
  normals_.add(frame.normals_ms);
  svo_.add(frame.svo_ms);
  cut_.add(drawn.cut_ms);
  render_.add(drawn.render_ms);
  points_ = frame.cloud.size();
  nodes_ = frame.svo.node_count();
  leaves_ = frame.svo.leaf_count();
  depth_ = frame.svo.depth;
  drawn_ = drawn.drawn;
}

std::string PlayReport::to_json() const {
  nlohmann::ordered_json json;
  json["source"] = source;
  json["gl_renderer"] = gl_renderer;
  json["mode"] = name(mode);
  json["delta"] = delta;
  json["layers"] = layers;
  json["size"] = {size.x, size.y};
  json["seconds"] = rounded(seconds);
  json["fps"] = seconds > 0.0 ? rounded(static_cast<double>(frames_shown_) / seconds) : 0.0;
  json["frames_shown"] = frames_shown_;
  json["frames_dropped"] = frames_dropped;
  json["errors"] = errors;
  json["fetched_bytes"] = fetched_bytes_;
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
  json["drawn"] = drawn_;
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

std::string PlayReport::to_title() const {
  return fmt::format(
      "{} points, depth {}, {} {}s drawn, {} frames shown, {} dropped, {} broken; median ms: fetch "
      "{:.1f}, decode {:.1f}, normals {:.1f}, octree {:.1f}, cut {:.1f}, render {:.1f}",
      points_, depth_, drawn_, name(mode), frames_shown_, frames_dropped, errors,
      fetch_.summary().median, decode_.summary().median, normals_.summary().median,
      svo_.summary().median, cut_.summary().median, render_.summary().median);
}

}  // namespace pointreel
