#include "tests/bench/scale/request_log.h"

#include <array>
#include <cstdio>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "pointreel/error.h"

namespace pointreel::bench {
namespace {

using nlohmann::json;

constexpr std::array<std::string_view, 3> kLayers = {"base", "middle", "full"};

struct LayerFileName {
  std::uint32_t first_frame, layer;
};

/// Reads names such as /reel/00030.base.6d4f74bd.prs.
std::optional<LayerFileName> layer_file_of(std::string_view target) {
  target.remove_prefix(target.rfind('/') + 1);
  const std::size_t dot = target.find('.');
  if (dot == std::string_view::npos || !target.ends_with(".prs")) return {};
  LayerFileName name{};
  if (std::sscanf(std::string(target.substr(0, dot)).c_str(), "%u", &name.first_frame) != 1)
    return {};
  const std::string_view layer = target.substr(dot + 1, target.find('.', dot + 1) - dot - 1);
  for (; name.layer < kLayers.size(); ++name.layer)
    if (kLayers[name.layer] == layer) return name;
  return {};
}

/// The seconds since midnight of a time such as 2026-11-25T21:59:49.361Z.
std::optional<double> seconds_of(const std::string& time) {
  int hours = 0, minutes = 0;
  double seconds = 0.0;
  if (std::sscanf(time.c_str(), "%*d-%*d-%*dT%d:%d:%lf", &hours, &minutes, &seconds) != 3)
    return {};
  return 3600.0 * hours + 60.0 * minutes + seconds;
}

}  // namespace

Result<std::vector<LoggedRequest>> read_request_log(const std::filesystem::path& file) {
  constexpr double kDay = 86'400.0;
  std::ifstream in(file);
  if (!in) return fail(ErrorCode::io, file.string() + ": cannot be read");
  std::vector<LoggedRequest> requests;
  std::map<std::uint32_t, std::uint32_t> segments;  // numbers by first frame
  std::optional<double> start;
  for (std::string line; std::getline(in, line);) {
    const json entry = json::parse(line, nullptr, false);
    if (!entry.is_object() || entry.value("event", "") != "request") continue;
    const auto name = layer_file_of(entry.value("target", ""));
    const auto seconds = seconds_of(entry.value("time", ""));
    const auto bytes = entry.value("bytes", std::uint64_t{0});
    if (!name || !seconds || bytes == 0) continue;
    if (!start) start = seconds;
    const double since = *seconds - *start;
    segments[name->first_frame] = 0;
    requests.push_back({since < 0.0 ? since + kDay : since, name->first_frame, name->layer, bytes});
  }
  if (requests.empty())
    return fail(ErrorCode::invalid,
                fmt::format("{}: has no request for a layer of a package; it must be what "
                            "pointreel-server serve --log info wrote",
                            file.string()));
  std::uint32_t count = 0;
  for (auto& [first_frame, number] : segments) number = count++;
  for (LoggedRequest& request : requests) request.segment = segments[request.segment];
  return requests;
}

}  // namespace pointreel::bench
