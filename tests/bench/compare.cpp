#include "tests/bench/compare.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "codec/distance/distance.h"
#include "codec/files/cloud_file.h"
#include "common/base/try.h"
#include "common/command_line/command.h"
#include "common/process/print.h"
#include "tests/bench/output.h"

namespace pointreel::bench {
namespace {

struct Options {
  std::string a, b, json;
  double peak = 0.0;  ///< 0: the largest extent of a
  int bits = 0;       ///< 0: no distances in voxels
};

/// The worse of both directions in every figure.
OneWayDistance symmetric(const CloudDistance& distance) {
  OneWayDistance both;
  both.mean_squared = distance.d1();
  both.max = distance.max();
  both.plane_mean_squared = distance.d2();
  both.plane_unknown = distance.a_to_b.plane_unknown + distance.b_to_a.plane_unknown;
  both.colors = distance.colors();
  both.normals = distance.normals();
  return both;
}

/// Mean squares, distances and PSNR; angles in degrees. Figures without attributes are missing.
nlohmann::json to_json(const OneWayDistance& distance, double peak) {
  // The JSON library writes infinity as null.
  nlohmann::json json = {{"d1", distance.mean_squared},
                         {"d1_psnr", geometry_psnr(distance.mean_squared, peak)},
                         {"max", distance.max}};
  if (distance.plane_mean_squared) {
    json["d2"] = *distance.plane_mean_squared;
    json["d2_psnr"] = geometry_psnr(*distance.plane_mean_squared, peak);
    json["d2_unknown"] = distance.plane_unknown;
  }
  if (distance.colors) {
    const glm::dvec3 psnr = color_psnr(*distance.colors);
    json["color_psnr"] = {{"y", psnr.x}, {"cb", psnr.y}, {"cr", psnr.z}, {"yuv", yuv_psnr(psnr)}};
  }
  if (distance.normals) {
    json["normals"] = {{"mean_degrees", glm::degrees(distance.normals->mean)},
                       {"percentile_95_degrees", glm::degrees(distance.normals->percentile_95)},
                       {"unknown", distance.normals->unknown}};
  }
  return json;
}

Result<PointCloud> load(const std::string& path) {
  LoadedCloud loaded = TRY(read_cloud_file(path));
  for (const std::string& warning : loaded.warnings) {
    print_error("pointreel-bench", path + ": " + warning);
  }
  if (loaded.cloud.empty()) return fail(path + ": has no points to compare");
  return std::move(loaded.cloud);
}

/// Prints the table of a comparison, with a row for each figure that the attributes permit.
class Table {
 public:
  Table(const CloudDistance& distance, double voxel)
      : columns_{distance.a_to_b, distance.b_to_a, symmetric(distance)}, voxel_(voxel) {
    print("{:<26} {:>12} {:>12} {:>12}\n", "", "a to b", "b to a", "symmetric");
  }

  using Figure = std::function<std::optional<double>(const OneWayDistance&)>;

  /// A row in the units of the files and, if the size of a voxel is known, another in voxels.
  void length(const std::string& name, const Figure& figure) const {
    row(name, "units", figure, 1.0);
    if (voxel_ > 0.0) row("", "voxels", figure, voxel_);
  }
  void ratio(const std::string& name, const Figure& figure) const { row(name, "dB", figure, 1.0); }
  void angle(const std::string& name, const Figure& figure) const { row(name, "deg", figure, 1.0); }

 private:
  void row(const std::string& name, const char* unit, const Figure& figure, double scale) const {
    std::string line = fmt::format("{:<19} {:<6}", name, unit);
    for (const OneWayDistance& column : columns_) {
      const auto value = figure(column);
      if (!value) return;
      line += fmt::format(" {:>12.5g}", *value / scale);
    }
    print("{}\n", line);
  }

  std::array<OneWayDistance, 3> columns_;
  double voxel_;
};

void print_distance(const CloudDistance& distance, double peak, double voxel) {
  const Table table(distance, voxel);
  const auto psnr = [peak](std::optional<double> mean_squared) {
    return mean_squared ? std::optional(geometry_psnr(*mean_squared, peak)) : std::nullopt;
  };
  const auto root = [](std::optional<double> mean_squared) {
    return mean_squared ? std::optional(std::sqrt(*mean_squared)) : std::nullopt;
  };
  table.length("D1 root mean square", [&](auto& d) { return root(d.mean_squared); });
  table.ratio("D1 PSNR", [&](auto& d) { return psnr(d.mean_squared); });
  table.length("D2 root mean square", [&](auto& d) { return root(d.plane_mean_squared); });
  table.ratio("D2 PSNR", [&](auto& d) { return psnr(d.plane_mean_squared); });
  table.length("maximum distance", [](auto& d) { return d.max; });
  constexpr std::array<const char*, 3> kComponents = {"Y", "Cb", "Cr"};
  for (int i = 0; i < 3; ++i) {
    table.ratio(
        fmt::format("colour PSNR {}", kComponents[static_cast<std::size_t>(i)]),
        [i](auto& d) { return d.colors ? std::optional(color_psnr(*d.colors)[i]) : std::nullopt; });
  }
  table.ratio("colour PSNR 6:1:1", [](auto& d) {
    return d.colors ? std::optional(yuv_psnr(color_psnr(*d.colors))) : std::nullopt;
  });
  table.angle("normals mean", [](auto& d) {
    return d.normals ? std::optional(glm::degrees(d.normals->mean)) : std::nullopt;
  });
  table.angle("normals 95 %", [](auto& d) {
    return d.normals ? std::optional(glm::degrees(d.normals->percentile_95)) : std::nullopt;
  });
  const auto normals = distance.normals();
  if (normals && normals->unknown > 0) {
    print("{} pairs of points, of both directions, have an unknown normal and no angle\n",
          grouped(normals->unknown));
  }
}

/// The grid that the errors refer to.
struct Grid {
  double peak;
  double voxel;  ///< 0 if unknown
  const char* reason;
};

Grid grid_of(const PointCloud& a, const Options& options) {
  const double voxels = std::ldexp(1.0, options.bits) - 1.0;
  const auto with = [&](double peak, const char* reason) {
    return Grid{peak, options.bits > 0 ? peak / voxels : 0.0, reason};
  };
  if (options.peak > 0.0) return with(options.peak, "as given");
  const double extent = bounding_cube(bounds(a)).edge;
  bool whole = options.bits > 0 && extent <= voxels;
  for (std::size_t i = 0; whole && i < a.size(); ++i) whole = a.world(i) == glm::floor(a.world(i));
  return whole ? with(voxels, "all coordinates of a are voxels")
               : with(extent, "largest extent of a");
}

Result<void> compare(const Options& options) {
  const PointCloud a = TRY(load(options.a));
  const PointCloud b = TRY(load(options.b));
  const CloudDistance distance = TRY(cloud_distance(a, b));

  const Grid grid = grid_of(a, options);
  if (options.json != "-") {
    print("a: {}, {} points\nb: {}, {} points\n", options.a, grouped(a.size()), options.b,
          grouped(b.size()));
    print("peak {:g} ({})", grid.peak, grid.reason);
    if (grid.voxel > 0.0) print(", voxel {:g} ({} bits)", grid.voxel, options.bits);
    print("\n\n");
    print_distance(distance, grid.peak, grid.voxel);
  }
  if (options.json.empty()) return {};
  nlohmann::json report = {{"a_to_b", to_json(distance.a_to_b, grid.peak)},
                           {"b_to_a", to_json(distance.b_to_a, grid.peak)},
                           {"symmetric", to_json(symmetric(distance), grid.peak)}};
  report["a"] = {{"file", options.a}, {"points", a.size()}};
  report["b"] = {{"file", options.b}, {"points", b.size()}};
  report["peak"] = grid.peak;
  if (grid.voxel > 0.0) report["voxel"] = grid.voxel;
  return write_json(options.json, report);
}

}  // namespace

void add_compare_command(cli::Command app, int& exit_code) {
  const cli::Command command = app.add_subcommand(
      "compare",
      "the distance between two clouds: D1, D2 and their PSNR, maximum, colours, normals");
  command.footer(
      "D1 is the mean squared distance from each point to its nearest neighbour in the other\n"
      "cloud, and D2 is the same along the normals of A. The table shows the square roots of "
      "both.\n"
      "The PSNR of geometry is 10 log10(3 peak^2 / D), that of colours is\n"
      "10 log10(255^2 / mean square) of Y'CbCr (BT.709). \"Symmetric\" is the worse of the two\n"
      "directions. The table leaves out rows for attributes that the files do not have.");
  auto options = std::make_shared<Options>();
  command
      .add_option("A", options->a,
                  "the reference, .ply, .drc, .npz or any other file that pack reads")
      .required();
  command.add_option("B", options->b, "the cloud to compare with it").required();
  command
      .add_option("--peak", options->peak,
                  "the peak of PSNR in the units of the files, such as 1023 for 10-bit voxels\n"
                  "[the largest extent of A]")
      .check(cli::positive_number());
  command
      .add_option("--bits", options->bits,
                  "also show distances in voxels, where the peak is 2^bits - 1 voxels; if all\n"
                  "coordinates of A are whole numbers, a voxel is 1 unit")
      .check(cli::range(1, 31));
  const cli::Option json =
      command
          .add_option("--json", options->json,
                      "write all figures as JSON to FILE; without FILE, or with -, print them\n"
                      "instead of the table. Infinite figures are null")
          .expected(0, 1)
          .type_name("[FILE]");
  command.callback([options, json, &exit_code] {
    if (json.count() > 0 && options->json.empty()) options->json.push_back('-');
    const auto done = compare(*options);
    if (!done) print_error("pointreel-bench", done.error().message);
    exit_code = done ? 0 : 1;
  });
}

}  // namespace pointreel::bench
