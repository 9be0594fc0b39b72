#include "tests/bench/surface/surface_plots.h"

#include <string>
#include <utility>
#include <vector>

#include "common/base/try.h"
#include "tests/bench/report/plot.h"

namespace pointreel::bench {
namespace {

using nlohmann::json;

constexpr int kOff = 5, kAuto = 1, kCurve = 0, kLibrary = 2, kMark = 3;  // styles

struct Figure {
  const char *key, *label;
};
constexpr Figure kErrors[] = {{"bits", "bits per point"},
                              {"distance_rms_mm", "distance to truth (rms), mm"},
                              {"normal_p95_degrees", "error of normals (95 %), degrees"},
                              {"psnr", "PSNR, dB"}};

double number(const json& row, const char* key) { return row[key].get<double>(); }

bool is(const json& row, const char* kind) { return row["kind"] == kind && row["depth"].is_null(); }

/// Points of the rows of this kind whose depth is not fixed.
template <class X>
Series series(const json& rows, const char* kind, std::string title, int style, const Figure& y,
              X x) {
  Series out{std::move(title), style, {}};
  for (const json& row : rows) {
    if (is(row, kind)) out.points.emplace_back(x(row), number(row, y.key));
  }
  return out;
}

/// A row of panels for each figure, a column for each group.
template <class Fill>
std::vector<Panel> panels(const json& report, const char* x_label, const Fill& fill) {
  std::vector<Panel> out;
  for (const Figure& figure : kErrors) {
    for (const json& group : report["groups"]) {
      const json& rows = group["rows"];
      Panel panel{group["group"], x_label, figure.label, false,
                  false,          {},      "off",        number(rows[0], figure.key)};
      panel.key_below = true;
      fill(panel, rows, figure);
      out.push_back(std::move(panel));
    }
  }
  return out;
}

std::vector<Panel> radius_panels(const json& report) {
  return panels(
      report, "radius of support, mm", [](Panel& panel, const json& rows, const Figure& y) {
        panel.log_x = true;
        panel.series.push_back(
            series(rows, "radius", "fixed radius", kCurve, y,
                   [](const json& row) { return 1000.0 * number(row, "value"); }));
        panel.series.push_back(series(rows, "auto", "auto (its median)", kAuto, y,
                                      [](const json& row) { return number(row, "radius_mm"); }));
      });
}

std::vector<Panel> beta_panels(const json& report) {
  return panels(report, "beta", [](Panel& panel, const json& rows, const Figure& y) {
    panel.series.push_back(series(rows, "beta", "beta", kCurve, y,
                                  [](const json& row) { return number(row, "value"); }));
    panel.series.push_back(series(rows, "auto", "auto", kAuto, y, [](const json&) { return 0.5; }));
  });
}

/// Distance over bits: a curve over the octree's depth for each way to clean, and a mark where pack
/// chooses the depth.
std::vector<Panel> rate_panels(const json& report) {
  const std::pair<const char*, int> kinds[] = {
      {"off", kOff}, {"auto", kAuto}, {"library", kLibrary}};
  std::vector<Panel> out;
  for (const json& group : report["groups"]) {
    Panel panel{
        group["group"], "bits per point", "distance to truth (rms), mm", true, true, {}, "", 0.0};
    panel.key_below = true;
    std::vector<Series> marks;
    for (const auto& [kind, style] : kinds) {
      const std::string title = kind == std::string("library") ? "CGAL bilateral" : kind;
      Series curve{title, style, {}};
      // A series of its own for each mark, so that no line joins them. One title stands for all.
      Series mark{marks.empty() ? "as pack chooses" : "", kMark, {}};
      for (const json& row : group["rows"]) {
        if (row["kind"] != kind) continue;
        const std::pair at(number(row, "bits"), number(row, "distance_rms_mm"));
        if (row["depth"].is_null()) {
          mark.points = {at};  // of the library, the last: the curve's number of passes
        } else {
          curve.points.push_back(at);
        }
      }
      if (curve.points.empty()) continue;
      panel.series.push_back(std::move(curve));
      marks.push_back(std::move(mark));
    }
    panel.series.insert(panel.series.end(), marks.begin(), marks.end());
    out.push_back(std::move(panel));
  }
  return out;
}

}  // namespace

Result<void> draw_surface_plots(const std::filesystem::path& folder, const json& report) {
  const int columns = static_cast<int>(report["groups"].size());
  TRY(draw_plot(folder / "surface_radius.svg", radius_panels(report), columns));
  TRY(draw_plot(folder / "surface_beta.svg", beta_panels(report), columns));
  return draw_plot(folder / "surface_rate.svg", rate_panels(report), columns);
}

}  // namespace pointreel::bench
