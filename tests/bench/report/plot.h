#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "pointreel/error.h"

namespace pointreel::bench {

/// Points that a line joins. The colour and the mark follow from `style`: the same number means the
/// same thing in every panel and plot.
struct Series {
  std::string title;
  int style;
  std::vector<std::pair<double, double>> points;  ///< finite and >= 0; on a logarithmic axis > 0
};

/// One diagram. Text is plain.
struct Panel {
  std::string title, x_label, y_label;
  bool log_x = false, log_y = false;
  std::vector<Series> series;
  /// A horizontal dashed line, where its title is not empty.
  std::string level_title;
  double level = 0.0;
};

/// Draws the panels, `columns` side by side, into an SVG file with Gnuplot. The picture takes light
/// or dark colours as the reader's system does, background included, so that it is readable in
/// both. An error if Gnuplot is missing or the file cannot be written.
Result<void> draw_plot(const std::filesystem::path& file, const std::vector<Panel>& panels,
                       int columns);

}  // namespace pointreel::bench
