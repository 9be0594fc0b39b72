#include "codec/segments/cleaning.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "common/base/words.h"

namespace pointreel {

void add_cleaning(Cleaning& to, const Cleaning& later) {
  if (later.frames == 0) return;
  to.frames += later.frames;
  to.removed += later.removed;
  to.spacing = later.spacing;
  to.noise = later.noise;
  to.radius = later.radius;
}

std::string cleaning_text(const Cleaning& cleaning) {
  return fmt::format("{}: noise {}, spacing {}, radius {}; {} removed",
                     counted(cleaning.frames, "frame"), number_text(cleaning.noise, 3),
                     number_text(cleaning.spacing, 3), number_text(cleaning.radius, 3),
                     counted(cleaning.removed, "point"));
}

nlohmann::ordered_json cleaning_json(const Cleaning& cleaning) {
  if (cleaning.frames == 0) return nullptr;
  return {{"frames", cleaning.frames},
          {"removed_points", cleaning.removed},
          {"spacing", cleaning.spacing},
          {"noise", cleaning.noise},
          {"radius", cleaning.radius}};
}

}  // namespace pointreel
