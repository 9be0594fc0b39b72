#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <glm/glm.hpp>

#include "client/options/settings.h"
#include "client/playback/stage.h"
#include "client/scene/camera_path.h"

namespace pointreel {

/// The direction from which the camera looks; radians, as in Camera.
struct View {
  double yaw = 0.0;
  double pitch = 0.0;
};

/// Everything that `pointreel play` can be told. The command line has checked that values are in
/// range and go together.
struct PlayOptions {
  std::vector<Stage::Placed> sources;               ///< at least one
  std::string token, ca_file, endpoint;             ///< as in SourceOptions
  bool follow_redirects = false;                    ///< as in SourceOptions
  std::uint64_t frame_memory = kFrameMemory >> 20;  ///< MiB that decoding a frame may take
  std::uint64_t cache = 512;                        ///< MiB of decoded frames that are kept
  Settings settings;                                ///< to begin with
  /// A window keeps in this file what the user changes of the settings; empty: nothing is kept.
  std::string settings_file;
  /// Layers of a package to fetch and decode, counted from the base; >= 1.
  std::uint32_t layers = kAllLayers;
  double speed = 1.0;
  bool audio = true;                      ///< reels are heard, and recorded, with their sound
  std::string audio_device = "default";   ///< as for open_audio_device
  Placement placement;                    ///< of the points of files
  std::optional<double> fps;              ///< as in SourceOptions
  std::string topic;                      ///< as in SourceOptions
  Reading reading;                        ///< as in SourceOptions
  std::optional<glm::ivec2> offscreen;    ///< draw pictures of this size, without a window
  std::optional<double> at;               ///< seconds
  std::optional<double> duration;         ///< seconds; of a reel drawn offscreen, of its own time
  std::optional<View> view;               ///< default: that of Camera::frame_bounds
  std::optional<Target> target;           ///< default: the middle of the scene
  double zoom = 1.0;                      ///< how much larger than as a whole the scene is shown
  std::optional<double> distance;         ///< from the target to the eye, in place of `zoom`
  std::optional<CameraPath> camera_path;  ///< in place of a view
  int supersample = 1;  ///< pictures that are written are drawn this many times as wide and high
  std::string screenshot, record, json;  ///< paths of files to write; empty: none
  /// When the process began. A duration counts from here.
  std::chrono::steady_clock::time_point started = std::chrono::steady_clock::now();

  /// The size of the pictures at first, in pixels.
  glm::ivec2 picture_size() const { return offscreen.value_or(settings.size); }
};

}  // namespace pointreel
