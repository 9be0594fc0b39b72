#include "codec/cloud_options/cloud_options.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include <fmt/ranges.h>

#include "common/base/letter_case.h"
#include "common/base/parse_double.h"
#include "pointreel/cloud.h"

namespace pointreel {
namespace {

std::vector<std::string> between_commas(const std::string& text) {
  std::vector<std::string> parts;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    parts.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  return parts;
}

}  // namespace

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

Result<std::vector<std::string>> parse_columns(const std::string& text) {
  std::vector<std::string> columns;
  for (const std::string& name : between_commas(text)) {
    if (name != "-" && name != "_" && !is_scalar_name(name)) {
      return fail(ErrorCode::argument,
                  fmt::format("\"{}\" in --columns is not the name of a column", name));
    }
    columns.push_back(name == "-" ? "_" : name);
  }
  for (const char* axis : {"x", "y", "z"}) {
    if (std::count_if(columns.begin(), columns.end(),
                      [&](const std::string& name) { return equal_in_any_case(name, axis); }) == 1)
      continue;
    return fail(ErrorCode::argument,
                fmt::format("\"{}\" does not have {} once, as in x,y,z,intensity", text, axis));
  }
  return columns;
}

std::vector<cli::Option> add_reading_options(cli::Command command, Reading& reading) {
  const cli::Option columns =
      command
          .add_option_function<std::string>(
              "--columns",
              [&reading](const std::string& text) { reading.columns = *parse_columns(text); },
              "what the columns of text are, or the floats of each point in .bin files, such as "
              "x,y,z,intensity,r,g,b; - for one to skip (default: by the file's header, or by the "
              "numbers in all files)")
          .check(cli::parsed_by(parse_columns))
          .type_name("NAMES");
  const cli::Option color_max =
      command
          .add_option("--color-max", reading.full_color,
                      "the number that is full brightness in colours of floats or of more than 8 "
                      "bits: 1, 255 or 65535 (default: by the colours in some files)")
          .check(cli::one_of({"1", "255", "65535"}))
          .type_name("NUMBER");
  const cli::Option omit =
      command
          .add_option_function<std::string>(
              "--omit-constant",
              [&reading](const std::string& text) {
                reading.omit_constant =
                    text == "-" ? std::vector<std::string>() : between_commas(text);
              },
              "scalar fields to leave out of frames in which they are the same at all points, or - "
              "for none (default: alpha, intensity and the like, if they are so in all frames that "
              "are looked at)")
          .type_name("NAMES");
  return {columns, color_max, omit};
}

std::vector<std::string> reading_arguments(const Reading& reading) {
  std::vector<std::string> arguments;
  if (!reading.columns.empty())
    arguments.push_back(fmt::format("--columns={}", fmt::join(reading.columns, ",")));
  if (reading.full_color != 0.0)
    arguments.push_back(fmt::format("--color-max={}", reading.full_color));
  if (reading.omit_constant) {
    arguments.push_back(fmt::format(
        "--omit-constant={}", reading.omit_constant->empty()
                                  ? "-"
                                  : fmt::format("{}", fmt::join(*reading.omit_constant, ","))));
  }
  return arguments;
}

std::vector<cli::Option> add_placement_options(cli::Command command, Placement& placement) {
  const cli::Option scale =
      command
          .add_option("--scale", placement.scale,
                      "multiply the coordinates of files by this, such as 0.001 for millimetres")
          .check(cli::number_within(1e-12, 1e12))
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

}  // namespace pointreel
