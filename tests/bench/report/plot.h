#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "pointreel/error.h"

namespace pointreel::bench {

/// Points that are joined by a line. `style` decides the colour and the mark; the same number means
/// the same thing in every panel and plot.
struct Series {
  std::string title;
  int style;
  std::vector<std::pair<double, double>> points;  ///< finite and >= 0; > 0 on a logarithmic axis
};

/// A diagram. Its texts are plain, without markup.
struct Panel {
  std::string title, x_label, y_label;
  bool log_x = false, log_y = false;
  std::vector<Series> series;
  /// A horizontal dashed line, drawn if its title is not empty.
  std::string level_title;
  double level = 0.0;
  bool key_below = false;  ///< the titles stand below the diagram, not in its upper right corner
};

/// Draws the panels into an SVG file with Gnuplot, `columns` of them side by side. The picture,
/// including its background, is light or dark like the reader's system. Fails if Gnuplot is missing
/// or the file cannot be written.
Result<void> draw_plot(const std::filesystem::path& file, const std::vector<Panel>& panels,
                       int columns);

}  // namespace pointreel::bench
