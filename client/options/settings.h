#pragma once

#include <cstdint>
#include <optional>

#include <glm/glm.hpp>

#include "client/prepare/prepare.h"
#include "client/scene/draw_options.h"
#include "client/scene/renderer_choice.h"
#include "pointreel/up.h"

namespace pointreel {

/// The largest width and height of a picture in pixels: every OpenGL 4.5 has textures of this size.
inline constexpr int kMaxImageSide = 16384;

/// What the user can change while a window plays, and what the window keeps for the next time
/// (settings_file.h). Names, ranges and words are in option_table.h.
struct Settings {
  glm::ivec2 size{1280, 720};  ///< of the window
  std::optional<bool> loop;    ///< by default a window loops, and playing offscreen does not
  double volume = 100.0;       ///< of sound, in percent: half of it sounds half as loud
  bool mute = false;           ///< whatever the volume
  RendererChoice renderer = RendererChoice::automatic;
  DrawOptions draw;
  double delta = PrepareOptions{}.delta;
  Refine refine = Refine::automatic;
  bool smooth_outlines = true;
  Drafts drafts = Drafts::playing;  ///< in a window; pictures that are written are never drafts
  bool floor = false;               ///< draw a grid on the floor
  bool drawing_panel = false, statistics_panel = false;  ///< whether they are open
  /// Size of the window's interface, where 1 is for 96 pixels per inch; 0: as the screen asks.
  double ui_scale = 0.0;
  /// With ColorSource::colors: a scalar field in place of colours. Not kept for the next time.
  ScalarChoice scalar;
  /// In place of what the package says. Not kept for the next time: it is about what plays.
  std::optional<Up> up;

  bool operator==(const Settings&) const = default;
};

/// How frames are prepared to be drawn with these settings. What the settings do not determine
/// stays as it is in `options`.
inline PrepareOptions prepare_options(const Settings& settings, PrepareOptions options) {
  options.mode = settings.draw.mode;
  options.delta = settings.delta;
  options.scalar = settings.draw.color == ColorSource::colors ? settings.scalar : ScalarChoice{};
  options.show_normals =
      (settings.draw.color != ColorSource::colors && settings.draw.color != ColorSource::plain) ||
      settings.draw.light != Light::flat;
  options.pixel_size = settings.draw.pixel_size;
  return options;
}

}  // namespace pointreel
