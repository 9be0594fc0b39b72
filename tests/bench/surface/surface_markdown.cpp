#include "tests/bench/surface/surface_markdown.h"

#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "tests/bench/measure.h"
#include "tests/bench/output.h"
#include "tests/bench/surface/close_views.h"
#include "tests/bench/table.h"

namespace pointreel::bench {
namespace {

using nlohmann::json;

std::string number(const json& row, const char* key, int digits, double factor = 1.0) {
  const json& value = row[key];
  return value.is_null() ? "" : fmt::format("{:.{}f}", factor * value.get<double>(), digits);
}

std::string whole(const json& row, const char* key) {
  return grouped(static_cast<std::size_t>(std::llround(row[key].get<double>())));
}

/// A length that may not apply.
std::string length(const json& row, const char* key) {
  return row[key] == 0.0 ? "" : number(row, key, 1);
}

std::vector<std::string> head(const char* first) {
  return {first,
          "radius, mm",
          "cell, mm",
          "surfels",
          "geometry, bits",
          "colours",
          "normals",
          "all",
          "bits per surfel",
          "clean, ms",
          "encode, ms",
          "decode, ms",
          "distance rms, mm",
          "95 %, mm",
          "normals mean, deg",
          "95 %, deg",
          "movement, mm",
          "PSNR, dB",
          "SSIM",
          "holes",
          "IoU"};
}

std::vector<std::string> cells(const std::string& first, const json& row) {
  const std::string holes = number(row, "holes", 2, 100.0);
  return {first,
          length(row, "radius_mm"),
          length(row, "cell_mm"),
          whole(row, "surfels"),
          number(row, "geometry_bits", 2),
          number(row, "color_bits", 2),
          number(row, "normal_bits", 2),
          number(row, "bits", 2),
          number(row, "surfel_bits", 1),
          number(row, "clean_ms", 0),
          number(row, "encode_ms", 1),
          number(row, "decode_ms", 1),
          number(row, "distance_rms_mm", 2),
          number(row, "distance_p95_mm", 2),
          number(row, "normal_mean_degrees", 1),
          number(row, "normal_p95_degrees", 1),
          number(row, "movement_rms_mm", 2),
          number(row, "psnr", 2),
          number(row, "ssim", 3),
          holes.empty() ? "" : holes + " %",
          number(row, "iou", 3)};
}

std::string settings(const json& rows) {
  Table table(head("setting"));
  for (const json& row : rows) {
    if (row["depth"].is_null()) table.row(cells(row["setting"], row));
  }
  return table.text();
}

std::string depths(const json& rows) {
  Table table(head("setting"));
  for (const json& row : rows) {
    if (!row["depth"].is_null()) table.row(cells(row["setting"], row));
  }
  return table.text();
}

std::string sequences(const json& report, const std::string& group) {
  Table table(head("sequence, setting"));
  for (const json& capture : report["captures"]) {
    if (capture["group"] != group) continue;
    for (const json& row : capture["rows"]) {
      if ((row["kind"] != "off" && row["kind"] != "auto") || !row["depth"].is_null()) continue;
      table.row(cells(fmt::format("{}, {}", capture["sequence"].get<std::string>(),
                                  row["setting"].get<std::string>()),
                      row));
    }
  }
  return table.text();
}

}  // namespace

std::string to_surface_markdown(const json& report) {
  const json& machine = report["machine"];
  std::string out = fmt::format(
      "# Cleaning\n\n"
      "Written by `pointreel-bench surface{}` at commit {} in {:.0f} s. Machine: {}, {} threads; "
      "{}, {} build.\n\n"
      "- Bits are those of each source point, with all headers. Times are medians on one thread.\n"
      "- Distance and normals compare decoded surfels with the true surface.\n"
      "- PSNR, SSIM, holes and IoU compare pictures of them with pictures of the true surface.\n"
      "- `radius` cleans with that radius of support everywhere, `beta` with another share of "
      "curvature: 0 is planes, auto has 0.5.\n"
      "- A setting without a cell did not clean, or pack chose the cells by the number of "
      "points.\n",
      report["quick"].get<bool>() ? " --quick" : "", machine["commit"].get<std::string>(),
      report["seconds"].get<double>(), machine["processor"].get<std::string>(),
      machine["cores"].get<int>(), machine["compiler"].get<std::string>(),
      machine["build"].get<std::string>());
  const json& library = report["library"];
  out += library.is_null()
             ? "- The rows of CGAL are left out: this program was built without libcgal-dev.\n\n"
             : fmt::format(
                   "- {} smooths bilaterally, once or several times over 50 neighbours. Its result "
                   "is coded in the cells of auto.\n\n",
                   library.get<std::string>());
  out +=
      "![Errors and bits over the radius of support](surface_radius.svg)\n\n"
      "![Errors and bits over beta](surface_beta.svg)\n\n"
      "![Distance over bits](surface_rate.svg)\n\n";
  for (const json& group : report["groups"]) {
    const std::string name = group["group"];
    out += fmt::format("## {}\n\nMeans over all frames.\n\n", name) + settings(group["rows"]) +
           "Close views, cleaned with auto:\n\n" + close_views_table(group["close_views"]) +
           "Octrees of fixed depth:\n\n" + depths(group["rows"]) + "Each sequence:\n\n" +
           sequences(report, name);
  }
  return out + bars_chapter(report);
}

}  // namespace pointreel::bench
