#include "tests/bench/surface/surface_bars.h"

#include <algorithm>
#include <string>

#include "tests/bench/surface/captures.h"

namespace pointreel::bench {
namespace {

using nlohmann::json;

/// Off and auto are always the first rows.
double off(const json& rows, const char* key) { return rows[0][key].get<double>(); }
double automatic(const json& rows, const char* key) { return rows[1][key].get<double>(); }
double ratio(const json& rows, const char* key) { return automatic(rows, key) / off(rows, key); }

}  // namespace

std::vector<Bar> surface_bars(const json& report) {
  std::vector<Bar> bars;
  for (const json& group : report["groups"]) {
    const std::string name = group["group"];
    const json& rows = group["rows"];
    const auto add = [&](const char* what, double value, const char* unit, double limit,
                         bool at_least = false) {
      bars.push_back({name + ": " + what, value, unit, limit, at_least});
    };
    const double decibels = automatic(rows, "psnr") - off(rows, "psnr");
    if (name == kDepthCameras) {
      add("movement, of that without", ratio(rows, "movement_rms_mm"), "", 0.3);
      add("bits, of those without cleaning", ratio(rows, "bits"), "", 0.35);
      add("decoding time, of that without", ratio(rows, "decode_ms"), "", 0.4);
      add("distance, of that without", ratio(rows, "distance_rms_mm"), "", 0.35);
      add("error of normals, of that without", ratio(rows, "normal_mean_degrees"), "", 0.4);
      add("PSNR gained", decibels, "dB", 4.0, true);
      add("holes, half of those without", 100.0 * automatic(rows, "holes"), "%",
          50.0 * off(rows, "holes"));
      continue;
    }
    add("movement, of that without", ratio(rows, "movement_rms_mm"), "", 0.3);
    add("bits, of those without cleaning", ratio(rows, "bits"), "", 0.75);
    add("distance, of that without", ratio(rows, "distance_rms_mm"), "", 0.8);
    add("error of normals, 95 %", automatic(rows, "normal_p95_degrees"), "deg", 25.0);
    add("PSNR gained", decibels, "dB", 1.5, true);
    add("holes", 100.0 * automatic(rows, "holes"), "%", 0.5);
    double least = 1.0;
    for (const json& capture : report["captures"]) {
      if (capture["group"] == name) least = std::min(least, automatic(capture["rows"], "iou"));
    }
    add("IoU of the worst sequence", least, "", 0.965, true);
  }
  return bars;
}

}  // namespace pointreel::bench
