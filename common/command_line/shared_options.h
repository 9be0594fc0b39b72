#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "common/cloud/placement.h"
#include "pointreel/codec.h"
#include "pointreel/error.h"

/// Options that several programs have.
namespace pointreel {

/// `mib` holds the value from here on: the default until one is given.
template <class Integer>
CLI::Option* add_frame_memory_option(CLI::App& command, Integer& mib) {
  mib = static_cast<Integer>(kFrameMemory >> 20);
  return command
      .add_option("--frame-memory", mib,
                  fmt::format("Memory that decoding a frame may take, in MiB (default: {}). Frames "
                              "that would need more are refused, because a few bytes can claim "
                              "millions of points; this also limits the time that a frame takes",
                              mib))
      ->check(CLI::Range(1, 1 << 20))
      ->type_name("MIB");
}

/// Three numbers such as 90,0,0.
Result<glm::dvec3> parse_degrees(const std::string& text);

/// --topic, for recordings of several.
CLI::Option* add_topic_option(CLI::App& command, std::string& topic);

/// --scale and --rotate, for files that were captured in other units or axes.
std::vector<CLI::Option*> add_placement_options(CLI::App& command, Placement& placement);

}  // namespace pointreel
