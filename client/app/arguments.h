#pragma once

#include <string>
#include <variant>

#include <glm/glm.hpp>

#include "client/options/play_options.h"
#include "pointreel/error.h"

/// Arguments of the command line that take more than a number or a name. Errors quote the argument
/// and say what is accepted.
namespace pointreel {

/// The direction from which to look, or a path for the camera to follow.
using CameraArgument = std::variant<View, CameraPath>;

/// "front", "back", "left", "right", "top", "bottom", "YAW,PITCH" in degrees, or the name of a file
/// with a camera path, which is read.
Result<CameraArgument> parse_camera(const std::string& text);

/// Two finite numbers, the first less than the second: "0,255".
Result<glm::dvec2> parse_interval(const std::string& text);
/// What --color says: an entry of the option table, or the name of a scalar field.
Result<void> set_color(const std::string& text, Settings& settings);
/// "X,Y,Z", each within +-1e9.
Result<glm::dvec3> parse_position(const std::string& text);
/// A position, or "feet", "middle" or "head".
Result<Target> parse_target(const std::string& text);

}  // namespace pointreel
