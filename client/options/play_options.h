#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "client/playback/stage.h"
#include "client/prepare/prepare.h"
#include "client/scene/camera_path.h"
#include "client/scene/draw_options.h"

namespace pointreel {

/// From where the camera looks; radians, as Camera's.
struct View {
  double yaw = 0.0;
  double pitch = 0.0;
};

/// Everything that `pointreel play` can be told. Values are in range: main checks them.
struct PlayOptions {
  std::vector<Stage::Placed> sources;  ///< at least one
  std::string token, ca_file;          ///< SourceOptions'
  DrawOptions draw;                    ///< its mode is the one to begin with
  double delta = PrepareOptions{}.delta;
  std::uint32_t layers = ~0u;  ///< fetch and decode so many of a package's, from the base; >= 1
  double speed = 1.0;
  std::optional<bool> loop;  ///< default: yes in a window, no offscreen
  double fps = 30.0;         ///< of folders
  std::optional<char> up;    ///< default: what the package says; y for folders
  bool offscreen = false;
  glm::ivec2 size{1280, 720};
  Drafts drafts = Drafts::playing;  ///< in a window; what is written is never one
  /// In a window: whether they are open at first.
  bool drawing_panel = false, statistics_panel = false;
  /// Where a window keeps what the user changes of all this (settings.h); empty: nowhere.
  std::string settings_file;
  std::optional<double> at;               ///< seconds
  std::optional<double> duration;         ///< seconds
  std::optional<View> view;               ///< default: Camera::frame_bounds'
  std::optional<CameraPath> camera_path;  ///< instead
  /// Of the window's interface, 1 for 96 pixels an inch; default: what the display says.
  std::optional<double> ui_scale;
  bool floor = false;                               ///< a grid on the floor
  std::chrono::steady_clock::time_point started{};  ///< when the process began
  int supersample = 1;  ///< pictures that are written are drawn so many times as wide and high
  std::string screenshot, record, json;  ///< paths; empty: none
};

/// How frames are prepared to be drawn like this.
inline PrepareOptions prepare_options(const DrawOptions& draw, double delta, std::uint32_t layers) {
  PrepareOptions options;
  options.mode = draw.mode;
  options.delta = delta;
  options.show_normals = draw.color == ColorSource::normals;
  options.pixel_size = draw.pixel_size;
  options.layers = layers;
  return options;
}

}  // namespace pointreel
