#include "tests/bench/stream/throughput.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <string>
#include <string_view>

#include <fmt/format.h>
#include <sys/wait.h>

#include "codec/package/manifest.h"
#include "common/base/try.h"
#include "pointreel/package.h"
#include "tests/bench/program.h"
#include "tests/e2e/server_address.h"
#include "tests/nginx/nginx.h"

namespace pointreel::bench {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr int kConnections = 32;

Result<std::string> output_of(const std::string& command) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> pipe(::popen(command.c_str(), "r"),
                                                             ::pclose);
  if (!pipe) return fail(ErrorCode::io, command + ": cannot be started");
  std::string text;
  std::array<char, 4096> piece;
  while (const std::size_t size = std::fread(piece.data(), 1, piece.size(), pipe.get())) {
    text.append(piece.data(), size);
  }
  return text;
}

Result<void> make_reel(const fs::path& scratch, const fs::path& reel, int frames) {
  const std::string input = (scratch / "throughput-frames").string();
  TRY(run_program("pointreel-synth",
                  {"soccer-shoot", "--frames", std::to_string(frames), "-o", input}));
  TRY(run_program("pointreel-server",
                  {"pack", "-i", input, "-o", reel.string(), "--codec", "octree"}));
  return {};
}

/// A Lua script for wrk, which repeats a list of requests.
struct Script {
  std::string name, about;
  fs::path file;
  std::size_t requests = 0;
};

/// Writes a script. Each request is a path with a range, or with "" for the whole file.
Script write_script(const fs::path& scratch, const std::string& name, const std::string& about,
                    const std::vector<std::pair<std::string, std::string>>& requests) {
  Script script{name, about, scratch / (name + ".lua"), requests.size()};
  std::ofstream out(script.file);
  out << "local all = {}\n";
  for (const auto& [path, range] : requests) {
    out << fmt::format("all[#all + 1] = {{'{}', '{}'}}\n", path, range);
  }
  out << R"lua(
local ready, at = {}, 0
init = function()
  for i, r in ipairs(all) do
    ready[i] = wrk.format("GET", r[1], r[2] ~= "" and {["Range"] = r[2], ["Host"] = "localhost"} or {["Host"] = "localhost"})
  end
end
request = function()
  at = at % #ready + 1
  return ready[at]
end
)lua";
  return script;
}

struct Rate {
  double requests = 0, megabytes = 0;  ///< per second
};

/// Runs wrk once.
Result<Rate> load(std::uint16_t port, const Script& script, int seconds) {
  const std::string text =
      TRY(output_of(fmt::format("wrk -t1 -c{} -d{} -s '{}' http://127.0.0.1:{}/ 2>&1", kConnections,
                                seconds, script.file.string(), port)));
  const auto after = [&](std::string_view label) -> std::string {
    const auto at = text.find(label);
    return at == std::string::npos ? "" : text.substr(at + label.size(), 40);
  };
  const std::string requests = after("Requests/sec:"), transfer = after("Transfer/sec:");
  if (requests.empty()) {
    return fail(ErrorCode::io, "wrk: " + text + " (if it is missing: apt-get install wrk)");
  }
  if (text.find("Non-2xx") != std::string::npos ||
      text.find("Socket errors") != std::string::npos) {
    return fail(ErrorCode::io, "wrk: " + text);
  }
  Rate rate;
  rate.requests = std::atof(requests.c_str());
  char* unit = nullptr;
  rate.megabytes = std::strtod(transfer.c_str(), &unit);
  if (*unit == 'K') rate.megabytes /= 1024.0;
  if (*unit == 'G') rate.megabytes *= 1024.0;
  return rate;
}

double median(std::vector<double> values) { return summarise(std::move(values)).median; }

/// Measures both servers in turn, so that a change of the machine's load affects both.
Result<json> compare(const Script& script, std::uint16_t ours, std::uint16_t nginx,
                     const StreamOptions& options, std::vector<Bar>& bars) {
  const int rounds = options.quick ? 3 : 9, seconds = options.quick ? 1 : 3;
  std::vector<double> ratios, our_requests, nginx_requests, our_bytes, nginx_bytes;
  for (int round = 0; round < rounds; ++round) {
    const bool first = round % 2 == 0;
    Rate our_rate = TRY(load(first ? ours : nginx, script, seconds));
    Rate nginx_rate = TRY(load(first ? nginx : ours, script, seconds));
    if (!first) std::swap(our_rate, nginx_rate);
    ratios.push_back(our_rate.requests / nginx_rate.requests);
    our_requests.push_back(our_rate.requests);
    nginx_requests.push_back(nginx_rate.requests);
    our_bytes.push_back(our_rate.megabytes);
    nginx_bytes.push_back(nginx_rate.megabytes);
  }
  const double ratio = median(ratios);
  bars.push_back(
      {fmt::format("HTTP throughput / nginx's, {}", script.about), ratio, "x", 0.9, true});
  return json{
      {"requests", script.requests},
      {"ratio", ratio},
      {"ratios", ratios},
      {"pointreel",
       {{"requests_per_second", median(our_requests)}, {"mib_per_second", median(our_bytes)}}},
      {"nginx",
       {{"requests_per_second", median(nginx_requests)}, {"mib_per_second", median(nginx_bytes)}}}};
}

}  // namespace

Result<json> run_throughput(const StreamOptions& options, std::vector<Bar>& bars) {
  const fs::path reels = options.scratch / "throughput";
  fs::create_directories(reels);
  const fs::path reel = reels / "shoot";
  TRY(make_reel(options.scratch, reel, options.quick ? 8 : 60));
  const Manifest manifest = TRY(read_manifest(reel));

  std::vector<std::pair<std::string, std::string>> whole, frames;
  for (const Segment& segment : manifest.segments) {
    for (const LayerFile& file : segment.layers) {
      whole.emplace_back("/shoot/" + file.path, "");
      for (std::size_t frame = 0; frame < file.frames.size(); ++frame) {
        const ByteRange range = byte_range(file, static_cast<std::uint32_t>(frame));
        if (range.size == 0) continue;
        frames.emplace_back("/shoot/" + file.path, fmt::format("bytes={}-{}", range.offset,
                                                               range.offset + range.size - 1));
      }
    }
  }

  e2e::Background server("pointreel-server", {"serve", reel.string(), "--listen", "127.0.0.1:0"});
  const std::uint16_t port = e2e::port_of(e2e::server_address(server));
  if (port == 0) return fail(ErrorCode::io, "pointreel-server: did not start");
  const auto nginx = TRY(Nginx::start(options.scratch / "nginx", [&](std::uint16_t own) {
    return nginx_configuration("packages.conf",
                               {{"listen 80;", fmt::format("listen 127.0.0.1:{};", own)},
                                {"/srv/pointreel", reels.string()}});
  }));

  json figures = {{"connections", kConnections}};
  for (const Script& script :
       {write_script(options.scratch, "segments", "whole layer files", whole),
        write_script(options.scratch, "frames", "single frames", frames)}) {
    figures[script.name] = TRY(compare(script, port, nginx->port(), options, bars));
  }
  return figures;
}

}  // namespace pointreel::bench
