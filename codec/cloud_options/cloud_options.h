#pragma once

#include <string>
#include <vector>

#include <fmt/format.h>

#include "codec/core/placement.h"
#include "codec/files/reading.h"
#include "common/command_line/command.h"
#include "pointreel/codec.h"
#include "pointreel/error.h"

/// Options of several programs that say how clouds are read.
namespace pointreel {

/// `mib` holds the value from here on: the default until one is given.
template <class Integer>
cli::Option add_frame_memory_option(cli::Command command, Integer& mib) {
  mib = static_cast<Integer>(kFrameMemory >> 20);
  return command
      .add_option("--frame-memory", mib,
                  fmt::format("Memory that decoding a frame may take, in MiB (default: {}). Frames "
                              "that would need more are refused, because a few bytes can claim "
                              "millions of points; this also limits the time that a frame takes",
                              mib))
      .check(cli::range(1, 1 << 20))
      .type_name("MIB");
}

/// Three numbers such as 90,0,0.
Result<glm::dvec3> parse_degrees(const std::string& text);

/// --topic, for recordings of several.
cli::Option add_topic_option(cli::Command command, std::string& topic);

/// Names such as x,y,z,intensity or x,y,z,-,r,g,b, with x, y and z among them; "-" and "_" stand
/// for columns to skip.
Result<std::vector<std::string>> parse_columns(const std::string& text);

/// --columns and --color-max, for files that do not tell it.
std::vector<cli::Option> add_reading_options(cli::Command command, Reading& reading);
/// What --columns and --color-max say, to be given to another command.
std::vector<std::string> reading_arguments(const Reading& reading);

/// --scale and --rotate, for files that were captured in other units or axes.
std::vector<cli::Option> add_placement_options(cli::Command command, Placement& placement);

}  // namespace pointreel
