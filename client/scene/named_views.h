#pragma once

#include <array>
#include <numbers>
#include <string_view>

namespace pointreel {

/// A direction from which the camera looks, with a name for people; radians, as in Camera.
struct NamedView {
  std::string_view name;
  double yaw, pitch;
};

inline constexpr std::array kNamedViews = {
    NamedView{"front", 0.0, 0.0},
    NamedView{"back", std::numbers::pi, 0.0},
    NamedView{"left", -0.5 * std::numbers::pi, 0.0},
    NamedView{"right", 0.5 * std::numbers::pi, 0.0},
    NamedView{"top", 0.0, 0.5 * std::numbers::pi},
    NamedView{"bottom", 0.0, -0.5 * std::numbers::pi},
};

/// What the camera looks at, as a share of the height of what the picture shows.
struct NamedHeight {
  std::string_view name;
  double height;
};

inline constexpr std::array kNamedHeights = {NamedHeight{"feet", 0.05}, NamedHeight{"middle", 0.5},
                                             NamedHeight{"head", 0.92}};

}  // namespace pointreel
