#include "common/command_line/shared_options.h"

#include <cmath>
#include <cstdlib>
#include <string_view>

#include "common/base/parse_double.h"

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

cli::Option add_topic_option(cli::Command command, std::string& topic) {
  return command
      .add_option("--topic", topic,
                  "which point clouds of an MCAP recording to take, if it has several topics")
      .type_name("NAME");
}

std::vector<cli::Option> add_placement_options(cli::Command command, Placement& placement) {
  const cli::Option scale =
      command
          .add_option("--scale", placement.scale,
                      "multiply the coordinates of files by this, such as 0.001 for millimetres")
          .check(cli::positive_number())
          .type_name("NUMBER");
  const cli::Option rotate =
      command
          .add_option_function<std::string>(
              "--rotate",
              [&placement](const std::string& text) {
                placement.rotation = rotation_of(*parse_degrees(text));
              },
              "turn the points of files about the axes x, y and z, in this order, by so many "
              "degrees, such as -90,0,0 to turn z up into y up")
          .check(cli::parsed_by(parse_degrees))
          .type_name("X,Y,Z");
  return {scale, rotate};
}

std::string fault_of_token(cli::Option option) {
  const std::string variable = option.envname();
  const char* environment = variable.empty() ? nullptr : std::getenv(variable.c_str());
  std::string place = option.name();
  std::string token = "unset";
  if (option.count() > 0) {
    token = option.value();
  } else if (environment != nullptr) {
    place = variable;
    token = environment;
  }
  if (token.empty()) return place + ": is empty; give a token, or leave it out";
  for (const char c : token) {
    if (static_cast<unsigned char>(c) <= ' ' || c == 127) {
      return place + ": has a space or a control character, which no token may have";
    }
  }
  return {};
}

}  // namespace pointreel
