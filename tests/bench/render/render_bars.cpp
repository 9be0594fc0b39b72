#include "tests/bench/render/render_bars.h"

#include <algorithm>
#include <limits>
#include <string>

namespace pointreel::bench {
namespace {

using nlohmann::json;

/// Bars of the software renderer at 1280x720.
void add_software(std::vector<Bar>& bars, const json& software) {
  for (const json& sequence : software["sequences"]) {
    const std::string name = sequence["name"].get<std::string>();
    const bool dense = name != "soccer-shoot";
    for (const json& row : sequence["modes"]) {
      if (row["mode"] != "surfel") continue;
      const json &by_software = row["software"], &by_opengl = row["opengl"];
      const auto ms = [](const json& of) { return of["ms"]["median"].get<double>(); };
      bars.push_back(
          {"software, " + name + ": surfels", ms(by_software), "ms", dense ? 25.0 : 12.0});
      bars.push_back({"software, " + name + ": speed over software OpenGL",
                      ms(by_opengl) / ms(by_software), "x", 4.0, true});
      bars.push_back({"software, " + name + ": PSNR below OpenGL",
                      by_opengl["psnr_mask"].get<double>() - by_software["psnr_mask"].get<double>(),
                      "dB", 0.3});
    }
    for (const json& row : sequence["playback"])
      if (row["renderer"] == "software")
        bars.push_back({"software, " + name + ": playback", row["fps"].get<double>(), "/s",
                        dense ? 24.0 : 30.0, true});
  }
  const json& dolly = software["dolly"];
  const double truth = dolly["truth"]["largest"].get<double>();
  for (const char* renderer : {"software", "opengl"})
    bars.push_back({std::string(renderer) + ": largest jump of a slow dolly over that of the truth",
                    dolly[renderer]["largest"].get<double>() / truth, "x", 1.3});
}

/// The mean of a figure of a setting over the views.
double mean(const json& scene, std::size_t row, const char* figure) {
  double sum = 0.0;
  for (const json& view : scene["views"]) {
    const json& value = view["rows"][row][figure];
    sum += value.is_null() ? 99.0 : value.get<double>();
  }
  return sum / static_cast<double>(scene["views"].size());
}

double median(const json& timing) { return timing["ms"]["median"].get<double>(); }

/// Bars for scenes without noise, drawn with the default, which is the first setting.
void add_dense(std::vector<Bar>& bars, const json& scene, bool gpu) {
  const std::string name = scene["scene"].get<std::string>() + ": ";
  bars.push_back({name + "holes", 100.0 * mean(scene, 0, "holes"), "%", 0.05});
  bars.push_back({name + "IoU", mean(scene, 0, "iou"), "", 0.998, true});
  bars.push_back({name + "PSNR", mean(scene, 0, "psnr_mask"), "dB", 34.0, true});
  if (gpu) {
    bars.push_back({name + "1,000,000 surfels", median(scene["views"][0]["rows"][0]), "ms", 1.0});
  }
}

/// Bars for scanned scenes: the default against the best of Figure 3.
void add_noisy(std::vector<Bar>& bars, const json& scene) {
  const std::string name = scene["scene"].get<std::string>() + ": ";
  double psnr = 0.0, holes = 1.0;
  const json& rows = scene["views"][0]["rows"];
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (!rows[i]["papers"].get<bool>()) continue;
    psnr = std::max(psnr, mean(scene, i, "psnr_mask"));
    holes = std::min(holes, mean(scene, i, "holes"));
  }
  bars.push_back({name + "PSNR above the best of Figure 3", mean(scene, 0, "psnr_mask") - psnr,
                  "dB", 0.0, true});
  bars.push_back({name + "holes above the fewest of Figure 3",
                  100.0 * (mean(scene, 0, "holes") - holes), "%", 0.0});
}

}  // namespace

std::vector<Bar> render_bars(const json& report) {
  const bool gpu = report["stopwatch"] == "gpu";
  std::vector<Bar> bars;
  double order = 0.0, flicker = 0.0, surfels = 0.0, voxels = 0.0, timed = 0.0;
  for (const json& scene : report["scenes"]) {
    scene["dense"].get<bool>() ? add_dense(bars, scene, gpu) : add_noisy(bars, scene);
    for (const json& view : scene["views"]) {
      const json& row = view["rows"][0];
      if (row.contains("flicker")) flicker = std::max(flicker, row["flicker"].get<double>());
      if (row.contains("order")) order = std::max(order, row["order"]["largest"].get<double>());
    }
    if (!scene.contains("tables")) continue;
    const json& tables = scene["tables"];
    const auto method = [&](const char* what, const char* of) {
      return median(tables[what]["methods"][of]);
    };
    surfels += method("surfels", "uniform") / method("surfels", "pull");
    voxels += method("voxels", "uniform") / median(tables["voxels"]["default"]);
    timed += 1.0;
    if (gpu && scene["motion"] == "kick") {
      bars.push_back(
          {"kick: two-pass surfels of 100,000 points", method("surfels", "pull"), "ms", 0.3});
    }
    if (scene["motion"] == "baseball") {
      bars.push_back({"baseball: traversal of the full view at depth 10",
                      tables["traverse_ms"]["median"].get<double>(), "ms", 1.0});
    }
  }
  bars.push_back({"order of the points, largest difference", order, "/255", 1.0});
  bars.push_back({"flicker of a static scene", flicker, "/255", 0.0});
  if (timed > 0.0 && !gpu) {
    bars.push_back(
        {"surfels: time of uniform buffers over that of pulling", surfels / timed, "x", 1.8, true});
    bars.push_back(
        {"voxels: time of whole cubes over that of visible faces", voxels / timed, "x", 1.5, true});
  }
  if (report.contains("software")) add_software(bars, report["software"]);
  for (const json& row : report.value("playback", json::array())) {
    if (row["mode"] != "surfel") continue;
    bars.push_back({"playback of soccer-shoot at 1280x720, surfels", row["fps"].get<double>(), "/s",
                    30.0, true});
  }
  return bars;
}

}  // namespace pointreel::bench
