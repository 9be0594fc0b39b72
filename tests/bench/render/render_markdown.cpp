#include "tests/bench/render/render_markdown.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "tests/bench/measure.h"
#include "tests/bench/output.h"
#include "tests/bench/table.h"

namespace pointreel::bench {
namespace {

using nlohmann::json;

double number(const json& value) { return value.get<double>(); }

/// A figure of a setting over all views of a scene.
struct Summary {
  double sum = 0.0, least = INFINITY, most = -INFINITY;
  int count = 0;

  double mean() const { return sum / count; }
};

template <class Figure>
Summary summarize(const json& scene, std::size_t row, const Figure& figure) {
  Summary summary;
  for (const json& view : scene["views"]) {
    const json value = figure(view["rows"][row]);
    if (value.is_null()) continue;
    summary.sum += number(value);
    summary.least = std::min(summary.least, number(value));
    summary.most = std::max(summary.most, number(value));
    ++summary.count;
  }
  return summary;
}

auto member(const char* name) {
  return [name](const json& row) { return row.contains(name) ? row[name] : json(nullptr); };
}

std::string quality_table(const json& scene) {
  Table table({"mode", "PSNR, dB", "worst view", "SSIM", "PSNR of picture", "SSIM of picture",
               "holes", "worst", "dilation", "IoU", "bleed", "order, RMS", "largest", "flicker",
               "ms"});
  const auto& first = scene["views"][0]["rows"];
  for (std::size_t i = 0; i < first.size(); ++i) {
    const auto of = [&](const char* name) { return summarize(scene, i, member(name)); };
    const auto share = [](double value) { return fmt::format("{:.3f} %", 100.0 * value); };
    const auto or_none = [](const Summary& summary, const std::string& text) {
      return summary.count > 0 ? text : std::string("-");
    };
    const Summary psnr = of("psnr_mask"), holes = of("holes"), bleed = of("bleed");
    const Summary rms = summarize(scene, i, [](const json& row) {
      return row.contains("order") ? row["order"]["rms"] : json(nullptr);
    });
    const Summary largest = summarize(scene, i, [](const json& row) {
      return row.contains("order") ? row["order"]["largest"] : json(nullptr);
    });
    const Summary ms = summarize(scene, i, [](const json& row) {
      return row.contains("ms") ? row["ms"]["median"] : json(nullptr);
    });
    table.row({first[i]["setting"], fmt::format("{:.2f}", psnr.mean()),
               fmt::format("{:.2f}", psnr.least), fmt::format("{:.4f}", of("ssim_mask").mean()),
               fmt::format("{:.2f}", of("psnr").mean()), fmt::format("{:.4f}", of("ssim").mean()),
               share(holes.mean()), share(holes.most), share(of("dilation").mean()),
               fmt::format("{:.4f}", of("iou").mean()), or_none(bleed, share(bleed.mean())),
               or_none(rms, fmt::format("{:.2f}", rms.most)),
               or_none(largest, fmt::format("{:.0f}", largest.most)),
               fmt::format("{:.0f}", of("flicker").most), fmt::format("{:.1f}", ms.mean())});
  }
  return table.text();
}

std::string views_of(const json& scene) {
  std::string out;
  for (const json& view : scene["views"]) {
    out += fmt::format("{}{} ({:.1f} % of the picture, from {:.2f} m)", out.empty() ? "" : ", ",
                       view["view"].get<std::string>(), 100.0 * number(view["coverage"]),
                       number(view["distance"]));
  }
  return out;
}

/// The best that any way of splatting can reach, if that is known.
std::string limits_of(const json& scene) {
  double sum = 0.0;
  std::string each;
  for (const json& view : scene["views"]) {
    if (view["sampling_limit"].is_null()) return "";
    const double limit = number(view["sampling_limit"]);
    sum += limit;
    each += fmt::format("{}{} {:.2f}", each.empty() ? "" : ", ", view["view"].get<std::string>(),
                        limit);
  }
  return fmt::format(
      "If the truth decides what is visible, Gaussian means of these points (0.4 spacings) reach "
      "{:.2f} dB ({}). The remaining error is due to details that are finer than the points.\n",
      sum / static_cast<double>(scene["views"].size()), each);
}

constexpr std::array kMethods = {"geometry", "uniform", "texture", "attribute", "pull"};

std::string milliseconds(const json& timing) {
  return fmt::format("{:.2f} ({:.2f} to {:.2f})", number(timing["median"]), number(timing["min"]),
                     number(timing["max"]));
}

/// Table II ("surfels") or IV ("voxels").
std::string times_table(const json& report, const char* what) {
  const bool voxels = what == std::string("voxels");
  std::vector<std::string> head = {"dataset"};
  if (voxels) head.insert(head.end(), {"depth", "paper's"});
  for (const char* method :
       {"geometry shader", "uniform buffer", "texture buffer", "vertex buffer"}) {
    head.insert(head.end(), {method, "paper's"});
  }
  head.insert(head.end(),
              {"pull", "PSNR, dB", "holes", "methods differ", "default", "PSNR, dB", "holes"});
  Table table(head);
  for (const json& scene : report["scenes"]) {
    if (!scene.contains("tables")) continue;
    const json& times = scene["tables"][what];
    const json& methods = times["methods"];
    std::vector<std::string> cells = {scene["scene"]};
    const json paper = times.contains("paper") ? times["paper"] : json::object();
    if (voxels) {
      cells.push_back(std::to_string(times["depth"].get<int>()));
      cells.push_back(std::to_string(paper.value("depth", 0)));
    }
    for (const char* method : kMethods) {
      cells.push_back(milliseconds(methods[method]["ms"]));
      if (paper.contains(method)) cells.push_back(fmt::format("{:.3f}", number(paper[method])));
    }
    const auto error = [&cells](const json& row) {
      cells.push_back(fmt::format("{:.2f}", number(row["psnr_mask"])));
      cells.push_back(fmt::format("{:.2f} %", 100.0 * number(row["holes"])));
    };
    error(methods["pull"]);
    cells.push_back(fmt::format("{:.3f} %", 100.0 * number(times["differ"])));
    cells.push_back(milliseconds(times["default"]["ms"]));
    error(times["default"]);
    table.row(cells);
  }
  return table.text();
}

std::string traversals(const json& report) {
  Table table({"dataset", "traversal at depth 10, ms"});
  for (const json& scene : report["scenes"]) {
    if (!scene.contains("tables")) continue;
    table.row({scene["scene"], milliseconds(scene["tables"]["traverse_ms"])});
  }
  return table.text();
}

std::string playback_table(const json& report) {
  if (!report.contains("playback")) return "";
  Table table({"mode", "frames per second", "decode, ms", "normals", "octree", "cut", "render"});
  for (const json& row : report["playback"]) {
    const auto cell = [&row](const char* figure) {
      return fmt::format("{:.1f}", number(row[figure]));
    };
    table.row({row["mode"], cell("fps"), cell("decode_ms"), cell("normals_ms"), cell("svo_ms"),
               cell("cut_ms"), cell("render_ms")});
  }
  return "Playback of soccer-shoot with `pointreel play` at 1280x720, with medians per frame. "
         "Frames are decoded while others are drawn.\n\n" +
         table.text();
}

std::string software_tables(const json& report) {
  if (!report.contains("software")) return "";
  const json& software = report["software"];
  Table times({"sequence", "mode", "elements", "software, ms", "OpenGL, ms", "ratio", "PSNR, dB",
               "of OpenGL", "holes", "of OpenGL", "IoU", "of OpenGL"});
  Table stages({"sequence", "mode", "WRP", "VIS", "SHD", "REC", "CLR", "fps"});
  Table playback(
      {"sequence", "renderer", "frames per second", "decode, ms", "octree", "cut", "render"});
  for (const json& sequence : software["sequences"]) {
    const std::string name = sequence["name"];
    for (const json& row : sequence["modes"]) {
      const json &ours = row["software"], &theirs = row["opengl"];
      const auto ms = [](const json& of) { return number(of["ms"]["median"]); };
      const auto percent = [](double share) { return fmt::format("{:.2f} %", 100.0 * share); };
      times.row({name, row["mode"], grouped(row["drawn"].get<std::size_t>()),
                 milliseconds(ours["ms"]), milliseconds(theirs["ms"]),
                 fmt::format("{:.1f}x", ms(theirs) / ms(ours)),
                 fmt::format("{:.2f}", number(ours["psnr_mask"])),
                 fmt::format("{:.2f}", number(theirs["psnr_mask"])), percent(number(ours["holes"])),
                 percent(number(theirs["holes"])), fmt::format("{:.4f}", number(ours["iou"])),
                 fmt::format("{:.4f}", number(theirs["iou"]))});
      double all = 0.0;
      for (const json& stage : row["stages"]) all += number(stage);
      const auto share = [&](const char* stage) {
        return fmt::format("{:.0f} %", 100.0 * number(row["stages"][stage]) / all);
      };
      stages.row({name, row["mode"], share("warp"), share("visibility"), share("shading"),
                  share("reconstruction"), share("clear"),
                  fmt::format("{:.1f}", 1000.0 / (ms(ours) + number(row["cut_ms"]["median"])))});
    }
    for (const json& row : sequence["playback"]) {
      const auto cell = [&row](const char* figure) {
        return fmt::format("{:.1f}", number(row[figure]));
      };
      playback.row({name, row["renderer"], cell("fps"), cell("decode_ms"), cell("svo_ms"),
                    cell("cut_ms"), cell("render_ms")});
    }
  }
  const json& dolly = software["dolly"];
  const auto largest = [&](const char* of) { return number(dolly[of]["largest"]); };
  return fmt::format(
      "\n## The software renderer\n\n{} at 1280x720, beside OpenGL in the same run. First frames "
      "of "
      "packages, whole figures in view; medians (least to most).\n\n{}\nThe share of each step, as "
      "in Table 3 of Pfister et al., Surfels: warping, visibility splatting, shading, "
      "reconstruction, and clearing.\n\n{}\nPlayback with `pointreel play`, with medians per "
      "frame.\n\n{}\nThe largest change between neighbouring pictures while the camera moves "
      "slowly "
      "away from the dense kick to 2.5 times the distance, in steps of 1/255: software {:.2f}, "
      "OpenGL {:.2f}, the supersampled truth {:.2f}.\n\n",
      software["renderer"].get<std::string>(), times.text(), stages.text(), playback.text(),
      largest("software"), largest("opengl"), largest("truth"));
}

/// The scenes one by one, and the times of drawing them; nothing if none was measured.
std::string scene_chapters(const json& report) {
  if (report["scenes"].empty()) return "";
  std::string out =
      "The truth is a picture made by casting a ray through the centre of each pixel to the "
      "analytic surface, which is coloured and lit as by the renderer. PSNR (of sRGB) and SSIM (of "
      "luma) are given over the pixels of the truth, and over the whole picture. Holes are pixels "
      "of the truth where nothing was drawn, dilation is pixels drawn outside of it, both as "
      "shares "
      "of the pixels of the truth. IoU is the number of pixels in both over that of pixels in "
      "either. Bleed is the share of covered pixels in which more than 5 % of the light comes from "
      "another surface or from the background. Order is the difference between two random orders "
      "of "
      "the points, in steps of 1/255. Flicker is the largest difference between two drawings of "
      "the "
      "same picture. Figures are means over the views; \"worst\" is the worst view. Bleed, order, "
      "flicker and milliseconds are those of the first view.\n";
  for (const json& scene : report["scenes"]) {
    out +=
        fmt::format("\n## {}\n\n{} points on {:.2f} m2 of surface, a spacing of {:.2f} mm. ",
                    scene["scene"].get<std::string>(), grouped(scene["points"].get<std::size_t>()),
                    number(scene["area"]), 1000.0 * number(scene["spacing"]));
    if (scene["dense"].get<bool>()) {
      out +=
          "The points are evenly spread and have no noise; splats have a radius of 0.7 spacings. ";
    }
    out += "Views: " + views_of(scene) + ".\n\n" + quality_table(scene);
    out += limits_of(scene);
  }
  out +=
      std::string("\n## Times: Tables II and IV of Slomp et al., Geometry Instancing\n\n") +
      (report["quick"].get<bool>()
           ? "**A quick run: small pictures, whose times, PSNR and holes are not those of the full "
             "run.**\n\n"
           : "") +
      "Milliseconds per picture, as the mean over the first and the last view, of frames that are "
      "already uploaded. "
      "Each cell has the median (least to most) of " +
      std::to_string(report["runs"].get<int>()) + " runs that take turns, " +
      (report["stopwatch"] == "gpu" ? "by timer queries"
                                    : "as wall time until the picture is complete") +
      ". Those of the paper are from an NVIDIA Quadro 3000M. All methods draw the same picture; "
      "\"methods differ\" is the largest share of pixels that differ by more than 1/255 from those "
      "of the geometry shader.\n\nTable II: surfels in two passes, the second enlarged by two "
      "(Figure 3 f).\n\n" +
      times_table(report, "surfels") +
      "Table IV: voxels as whole cubes, octree for delta = 5 %.\n\n" +
      times_table(report, "voxels") +
      "Traversal of the octree of the whole figure on one thread.\n\n" + traversals(report);
  return out;
}

}  // namespace

std::string to_render_markdown(const json& report) {
  std::string out = "# Pictures against the true surface\n\n";
  const json& machine = report["machine"];
  const std::string size =
      report["scenes"].empty()
          ? ""
          : fmt::format(" at {}x{}", report["size"][0].get<int>(), report["size"][1].get<int>());
  out += fmt::format("{}{}; {}, {} threads; {}, commit {}; {:.0f} s.\n\n",
                     machine["gl_renderer"].get<std::string>(), size,
                     machine["processor"].get<std::string>(), machine["cores"].get<int>(),
                     machine["compiler"].get<std::string>(), machine["commit"].get<std::string>(),
                     number(report["seconds"]));
  out += scene_chapters(report) + playback_table(report) + software_tables(report) +
         bars_chapter(report);
  return out;
}

}  // namespace pointreel::bench
