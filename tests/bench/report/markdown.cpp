#include "tests/bench/report/markdown.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "tests/bench/measure.h"
#include "tests/bench/output.h"
#include "tests/bench/table.h"

namespace pointreel::bench {
namespace {

using nlohmann::json;

double number(const json& value) { return value.get<double>(); }

/// The number, rounded and with separators.
std::string whole(const json& value) {
  return grouped(static_cast<std::size_t>(std::llround(number(value))));
}

/// Null stands for an infinite PSNR: there is no error at all.
std::string decibels(const json& value) {
  return value.is_null() ? "exact" : fmt::format("{:.1f}", number(value));
}

std::string percent(const json& value) { return fmt::format("{:.2f} %", 100.0 * number(value)); }

std::string off_by(const json& ours, const json& papers) {
  return fmt::format("{:+.1f} %", 100.0 * (number(ours) / number(papers) - 1.0));
}

std::string milliseconds(const json& timing) {
  return fmt::format("{:.2f} ({:.2f} to {:.2f})", number(timing["median"]), number(timing["min"]),
                     number(timing["max"]));
}

std::string points_per_pose(const json& structure) {
  Table table({"sequence", "poses", "points per pose", "least", "most", "paper's", "difference"});
  for (const json& sequence : structure) {
    const json& points = sequence["points"];
    table.row({sequence["dataset"],
               fmt::format("{} of {}", sequence["measured_poses"].get<int>(),
                           sequence["poses"].get<int>()),
               whole(points["mean"]), whole(points["min"]), whole(points["max"]),
               whole(sequence["paper"]["points"]),
               off_by(points["mean"], sequence["paper"]["points"])});
  }
  return table.text();
}

std::string depths(const json& counts) {
  std::string out;
  for (const auto& [depth, poses] : counts.items()) {
    out += fmt::format("{}{}", out.empty() ? "" : ", ", depth);
    if (counts.size() > 1) out += fmt::format(" ({} poses)", poses.get<int>());
  }
  return out;
}

std::string octree_structure(const json& structure) {
  Table table({"sequence", "delta", "depth", "paper's", "lost", "paper's", "inner nodes", "paper's",
               "leaves", "paper's", "difference"});
  for (const json& sequence : structure) {
    for (const json& row : sequence["rows"]) {
      const json& paper = row["paper"];
      table.row({sequence["dataset"], fmt::format("{:.0f} %", 100 * number(row["delta"])),
                 depths(row["poses_by_depth"]), whole(paper["depth"]), percent(row["loss"]),
                 percent(paper["loss"]), whole(row["nodes"]), whole(paper["nodes"]),
                 whole(row["leaves"]), whole(paper["leaves"]),
                 off_by(row["leaves"], paper["leaves"])});
    }
  }
  return table.text();
}

std::string octree_times(const json& structure) {
  Table table({"sequence", "delta", "build, ms", "recursive build, ms", "ratio", "traverse, ms",
               "paper's build", "paper's traverse"});
  for (const json& sequence : structure) {
    for (const json& row : sequence["rows"]) {
      table.row({sequence["dataset"], fmt::format("{:.0f} %", 100 * number(row["delta"])),
                 milliseconds(row["build_ms"]), milliseconds(row["recursive_ms"]),
                 fmt::format("{:.1f}x", number(row["ratio"])), milliseconds(row["traverse_ms"]),
                 fmt::format("{:.2f}", number(row["paper"]["build_ms"])),
                 fmt::format("{:.2f}", number(row["paper"]["traverse_ms"]))});
    }
  }
  return table.text();
}

/// Metres as millimetres.
std::string millimetres(const json& metres) {
  return fmt::format("{:.3f}", 1000.0 * number(metres));
}

std::string sizes_and_errors(const json& dataset) {
  Table table({"codec", "setting", "points", "geometry", "colours", "normals", "all", "D1, dB",
               "D2, dB", "largest error, cells", "to truth: mean, mm", "95 %", "99.9 %",
               "Y / Cb / Cr, 6:1:1, dB", "normals mean / 95 %, deg"});
  const json& scan = dataset["truth"];
  table.row({"source", "", whole(dataset["points"]), "", "", "", "", "", "", "",
             millimetres(scan["mean"]), millimetres(scan["p95"]), millimetres(scan["p999"]), "",
             ""});
  for (const json& row : dataset["rows"]) {
    const json &bits = row["bits"], &truth = row["truth"], &color = row["color_psnr"];
    const json& normal = row["normal_degrees"];
    table.row({row["codec"], row["setting"], whole(row["coded_points"]),
               fmt::format("{:.2f}", number(bits["geometry"])),
               fmt::format("{:.2f}", number(bits["colors"])),
               fmt::format("{:.2f}", number(bits["normals"])),
               fmt::format("{:.2f}", number(bits["all"])), decibels(row["d1_psnr"]),
               decibels(row["d2_psnr"]), fmt::format("{:.2f}", number(row["max_cells"])),
               millimetres(truth["mean"]), millimetres(truth["p95"]), millimetres(truth["p999"]),
               fmt::format("{} / {} / {}, {}", decibels(color["y"]), decibels(color["cb"]),
                           decibels(color["cr"]), decibels(color["yuv"])),
               fmt::format("{:.2f} / {:.2f}", number(normal["mean"]), number(normal["p95"]))});
  }
  return table.text();
}

std::string speed_and_memory(const json& dataset) {
  Table table({"codec", "setting", "encode, ms", "decode, ms", "to SVO, ms", "D1 rms, mm",
               "pack, MiB", "unpack, MiB"});
  for (const json& row : dataset["rows"]) {
    table.row({row["codec"], row["setting"], milliseconds(row["encode_ms"]),
               milliseconds(row["decode_ms"]), milliseconds(row["svo_ms"]),
               millimetres(row["d1_rms"]), fmt::format("{:.0f}", number(row["pack_mib"])),
               fmt::format("{:.0f}", number(row["unpack_mib"]))});
  }
  return table.text();
}

std::string codecs(const json& datasets) {
  std::string out;
  for (const json& dataset : datasets) {
    out += fmt::format(
        "### {}\n\n{} poses, {} points per pose; the peak of PSNR is that of {} bits; the edge of "
        "the cube is {:.3f} m.\n\n",
        dataset["dataset"].get<std::string>(), dataset["poses"].get<int>(),
        whole(dataset["points"]), dataset["peak_bits"].get<int>(), number(dataset["edge"]));
    out += sizes_and_errors(dataset) + speed_and_memory(dataset);
    for (const json& end : dataset["noise_ends"]) {
      out += fmt::format(
          "- {}: a finer setting than {} gains nothing, because its mean distance to the true "
          "surface is already {} mm; that of the source is {} mm.\n",
          end["codec"].get<std::string>(), end["setting"].get<std::string>(),
          millimetres(end["mean"]), millimetres(dataset["truth"]["mean"]));
    }
    out += '\n';
  }
  return out;
}

std::string stability(const json& checks) {
  Table table({"stage", "case", "required", "measured", ""});
  for (const json& check : checks) {
    table.row({check["stage"], check["subject"], check["required"], check["outcome"],
               check["passed"].get<bool>() ? "holds" : "**fails**"});
  }
  return table.text();
}

}  // namespace

std::string to_markdown(const json& report) {
  const json& machine = report["machine"];
  std::string out = fmt::format(
      "# Speed against error\n\n"
      "Written by `pointreel-bench report{}` at commit {} in {:.0f} s.\n"
      "Machine: {}, {} threads; {}, {} build. Times are medians (least to most) on one thread, in "
      "milliseconds.\nSizes are bits per source point, including headers. Errors are those of "
      "MPEG's pc_error: D1 from point to point,\nD2 from point to plane, the worse of the two "
      "directions.\n\n",
      report["quick"].get<bool>() ? " --quick" : "", machine["commit"].get<std::string>(),
      number(report["seconds"]), machine["processor"].get<std::string>(),
      machine["cores"].get<int>(), machine["compiler"].get<std::string>(),
      machine["build"].get<std::string>());
  out +=
      "## Size against the distance to the true surface\n\n"
      "![Size against distance to truth](size_truth.svg)\n\n"
      "The dashed line is the distance from the source to the surface that was scanned. Where a "
      "curve meets it, finer\ncoding only preserves the noise of the scanner.\n\n"
      "## Size against the distance to the source\n\n![Size against D1](size_d1.svg)\n\n"
      "## Colours of the octree\n\n![Size against luma](size_luma.svg)\n\n"
      "## Speed against error\n\n![Encoding time against D1](encode_d1.svg)\n\n"
      "![Decoding time against D1](decode_d1.svg)\n\n"
      "## Points per pose (Slomp et al., Table I)\n\n"
      "The paper is Slomp et al., *Hardware-Accelerated Geometry Instancing for Surfel and Voxel "
      "Rendering of Scanned 4D\nMedia*.\n\n" +
      points_per_pose(report["structure"]) + "## Octrees (Slomp et al., Table III)\n\n" +
      octree_structure(report["structure"]) +
      "The ratio compares the recursive build with ours on this machine, in the same run. The "
      "paper's own times were\nmeasured in 2012 on an Intel Core i5-2540M at 2.6 GHz and are for "
      "reference only.\n\n" +
      octree_times(report["structure"]) +
      "## Codecs\n\nColours and normals are compared with those of the nearest source point. The "
      "bits of colours and normals\ninclude their headers. \"To SVO\" is the time from the encoded "
      "bytes to a tree that can be traversed. Memory is\nthe peak of `pointreel-server pack` and "
      "`unpack` on one thread.\n\n" +
      codecs(report["codecs"]) + "## Numerical stability\n\n" + stability(report["stability"]) +
      bars_chapter(report);
  return out;
}

}  // namespace pointreel::bench
