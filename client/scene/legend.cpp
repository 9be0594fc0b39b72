#include "client/scene/legend.h"

#include <cstddef>

#include "client/scene/scalar_colors.h"
#include "common/base/words.h"

namespace pointreel {

std::optional<Legend> legend_of(const Scene& scene) {
  constexpr std::size_t kMostLabels = 16;
  constexpr int kDigits = 4;
  for (const PlacedFrame& placed : scene) {
    if (placed.frame == nullptr || !placed.frame->scalar) continue;
    const ShownScalar& shown = *placed.frame->scalar;
    Legend legend{shown.range.name, {}, {}, {}};
    if (!shown.range.labels) {
      legend.least = number_text(shown.range.least, kDigits);
      legend.most = number_text(shown.range.most, kDigits);
      return legend;
    }
    for (const int label : shown.labels) {
      if (legend.labels.size() == kMostLabels) break;
      legend.labels.emplace_back(label_color(label), std::to_string(label));
    }
    return legend;
  }
  return std::nullopt;
}

}  // namespace pointreel
