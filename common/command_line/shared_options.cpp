#include "common/command_line/shared_options.h"

#include <cmath>
#include <string_view>

#include "common/base/parse_double.h"
#include "common/command_line/option_checks.h"

namespace pointreel {

Result<glm::dvec3> parse_degrees(const std::string& text) {
  glm::dvec3 degrees(0.0);
  const char* at = text.data();
  const char* const end = at + text.size();
  for (int axis = 0; axis < 3; ++axis) {
    const auto [stop, error] = parse_double(at, end, degrees[axis]);
    const bool last = axis == 2;
    if (error != std::errc() || !(std::abs(degrees[axis]) <= 360.0) || (stop == end) != last ||
        (!last && *stop != ',')) {
      return fail(ErrorCode::argument,
                  fmt::format("\"{}\" is not three numbers of degrees from -360 to 360, such as "
                              "-90,0,0",
                              text));
    }
    at = stop + 1;
  }
  return degrees;
}

CLI::Option* add_topic_option(CLI::App& command, std::string& topic) {
  return command
      .add_option("--topic", topic,
                  "which point clouds of an MCAP recording to take, if it has several topics")
      ->type_name("NAME");
}

std::vector<CLI::Option*> add_placement_options(CLI::App& command, Placement& placement) {
  CLI::Option* scale =
      command
          .add_option("--scale", placement.scale,
                      "multiply the coordinates of files by this, such as 0.001 for millimetres")
          ->check(positive_number())
          ->type_name("NUMBER");
  CLI::Option* rotate =
      command
          .add_option_function<std::string>(
              "--rotate",
              [&placement](const std::string& text) {
                placement.rotation = rotation_of(*parse_degrees(text));
              },
              "turn the points of files about the axes x, y and z, in this order, by so many "
              "degrees, such as -90,0,0 to turn z up into y up")
          ->check([](const std::string& text) {
            const Result<glm::dvec3> degrees = parse_degrees(text);
            return degrees ? std::string() : degrees.error().message;
          })
          ->type_name("X,Y,Z");
  return {scale, rotate};
}

}  // namespace pointreel
