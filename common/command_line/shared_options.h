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
                  fmt::format("The memory that decoding a frame may take, in MiB (default: {}). A "
                              "frame that claims so many points that it would take more is not "
                              "decoded, because few bytes can claim many points; this bounds its "
                              "time too",
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
