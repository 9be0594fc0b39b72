#include "tests/bench/report/plot.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <string_view>

#include <fmt/format.h>

#include "tests/bench/output.h"

namespace pointreel::bench {
namespace {

namespace fs = std::filesystem;

constexpr int kPanelWidth = 480, kPanelHeight = 360;

/// Colours that colour-blind people can tell apart (Okabe and Ito), with contrast on white and on
/// black. The marks differ as well.
struct Style {
  std::string_view color;
  int mark;
};
constexpr std::array<Style, 6> kStyles = {{{"#0072b2", 7},
                                           {"#d55e00", 5},
                                           {"#009e73", 9},
                                           {"#cc79a7", 13},
                                           {"#b58900", 11},
                                           {"#808080", 6}}};

/// Gnuplot writes its colours as attributes, which this style sheet overrides.
constexpr std::string_view kStyleSheet = R"(<style>
#gnuplot_canvas > rect:first-child { fill: #ffffff }
[stroke="black"] { stroke: #1f2328 } [fill="black"] { fill: #1f2328 } [color="black"] { color: #1f2328 }
@media (prefers-color-scheme: dark) {
#gnuplot_canvas > rect:first-child { fill: #0d1117 }
[stroke="black"] { stroke: #e6edf3 } [fill="black"] { fill: #e6edf3 } [color="black"] { color: #e6edf3 }
}
</style>
)";

/// A string for Gnuplot. Within single quotes only the quote itself is special; it is doubled.
std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) {
    out += c;
    if (c == '\'') out += c;
  }
  return out + "'";
}

/// Commands for an axis that holds these values with a margin. A logarithmic axis gets several
/// marks per decade, because an axis of less than a decade would otherwise have hardly any.
std::string axis(char name, bool logarithmic, const std::vector<double>& values) {
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  if (least == values.end()) return {};
  if (!logarithmic) {
    return fmt::format("unset logscale {0}\nset {0}range [0:{1:.9g}]\nset {0}tics autofreq\n", name,
                       *most > 0.0 ? 1.05 * *most : 1.0);
  }
  constexpr double kMargin = 1.3;
  std::string marks;
  for (double decade = 1e-6; decade < 1e6; decade *= 10.0) {
    for (const double digit : {1.0, 1.5, 2.0, 3.0, 5.0, 7.0}) {
      marks += fmt::format("{}{:.9g}", marks.empty() ? "" : ", ", digit * decade);
    }
  }
  return fmt::format("set logscale {0}\nset {0}range [{1:.9g}:{2:.9g}]\nset {0}tics ({3})\n", name,
                     *least / kMargin, *most * kMargin, marks);
}

std::string axes(const Panel& panel) {
  std::vector<double> x, y;
  for (const Series& series : panel.series) {
    for (const auto& [px, py] : series.points) {
      x.push_back(px);
      y.push_back(py);
    }
  }
  if (!panel.level_title.empty()) y.push_back(panel.level);
  return axis('x', panel.log_x, x) + axis('y', panel.log_y, y);
}

std::string script_of(const Panel& panel) {
  std::string out;
  for (std::size_t i = 0; i < panel.series.size(); ++i) {
    out += fmt::format("$series{} << EOD\n", i);
    for (const auto& [x, y] : panel.series[i].points) out += fmt::format("{:.9g} {:.9g}\n", x, y);
    out += "EOD\n";
  }
  out += fmt::format("set title {}\nset xlabel {}\nset ylabel {}\n", quoted(panel.title),
                     quoted(panel.x_label), quoted(panel.y_label));
  out += panel.key_below ? "set key below samplen 2\nset bmargin 6.5\n"
                         : "set key inside top right samplen 2\nset bmargin -1\n";
  out += axes(panel);
  out += "plot ";
  for (std::size_t i = 0; i < panel.series.size(); ++i) {
    const Style& style = kStyles[static_cast<std::size_t>(panel.series[i].style) % kStyles.size()];
    out += fmt::format(
        "$series{} using 1:2 with linespoints linecolor rgb '{}' pointtype {} "
        "pointsize 0.7 title {}, ",
        i, style.color, style.mark, quoted(panel.series[i].title));
  }
  if (!panel.level_title.empty()) {
    out += fmt::format("{:.9g} with lines dashtype 2 linecolor rgb '#808080' title {}", panel.level,
                       quoted(panel.level_title));
  }
  return out + "\n";
}

Result<void> add_style_sheet(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string svg{std::istreambuf_iterator<char>(in), {}};
  const std::size_t place = svg.find("<g id=\"gnuplot_canvas\">");
  if (!in || place == std::string::npos) {
    return fail(ErrorCode::io, file.string() + ": Gnuplot drew no picture");
  }
  svg.insert(place, kStyleSheet);
  return write_text(file, svg);
}

}  // namespace

Result<void> draw_plot(const fs::path& file, const std::vector<Panel>& panels, int columns) {
  const int rows = (static_cast<int>(panels.size()) + columns - 1) / columns;
  std::string script = fmt::format(
      "set terminal svg size {},{} dynamic noenhanced font 'sans-serif,13' linewidth 1.4\n"
      "set output {}\nset grid\n"
      "set multiplot layout {},{}\n",
      columns * kPanelWidth, rows * kPanelHeight, quoted(file.string()), rows, columns);
  for (const Panel& panel : panels) script += script_of(panel);
  script += "unset multiplot\n";
  std::FILE* gnuplot = popen("gnuplot", "w");
  if (gnuplot == nullptr) return fail(ErrorCode::io, "gnuplot: cannot be started");
  std::fwrite(script.data(), 1, script.size(), gnuplot);
  if (pclose(gnuplot) != 0) {
    return fail(ErrorCode::io,
                file.string() + ": Gnuplot failed; if it is missing, install gnuplot-nox");
  }
  return add_style_sheet(file);
}

}  // namespace pointreel::bench
