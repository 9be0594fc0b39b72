#include "tests/bench/stream/throughput.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <string_view>

#include <fmt/format.h>
#include <sys/wait.h>

#include "pointreel/package.h"
#include "tests/e2e/process.h"
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
  if (!pipe) return fail(command + ": cannot be started");
  std::string text;
  std::array<char, 4096> piece;
  while (const std::size_t size = std::fread(piece.data(), 1, piece.size(), pipe.get())) {
    text.append(piece.data(), size);
  }
  return text;
}

Result<void> make_reel(const fs::path& scratch, const fs::path& reel, int frames) {
  const std::string input = (scratch / "throughput-frames").string();
  for (const auto& [program, arguments] :
       {std::pair<std::string, std::vector<std::string>>{
            "pointreel-synth", {"soccer-shoot", "--frames", std::to_string(frames), "-o", input}},
        {"pointreel-server", {"pack", "-i", input, "-o", reel.string()}}}) {
    const auto made = e2e::run(program, arguments);
    if (made.exit_code != 0) return fail(program + ": " + made.err);
  }
  return {};
}

/// What is asked for, again and again, as Lua that wrk reads: paths, and ranges or "".
struct Script {
  std::string name, about;
  fs::path file;
  std::size_t requests = 0;
};

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
    ready[i] = wrk.format("GET", r[1], r[2] ~= "" and {["Range"] = r[2], ["Host"] = "bench"} or {["Host"] = "bench"})
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
  double requests = 0, megabytes = 0;  ///< a second
};

/// One run of wrk.
Result<Rate> load(std::uint16_t port, const Script& script, int seconds) {
  const auto text = output_of(fmt::format("wrk -t1 -c{} -d{} -s '{}' http://127.0.0.1:{}/ 2>&1",
                                          kConnections, seconds, script.file.string(), port));
  if (!text) return tl::unexpected(text.error());
  const auto behind = [&](std::string_view what) -> std::string {
    const auto at = text->find(what);
    return at == std::string::npos ? "" : text->substr(at + what.size(), 40);
  };
  const std::string requests = behind("Requests/sec:"), transfer = behind("Transfer/sec:");
  if (requests.empty()) return fail("wrk: " + *text + " (apt-get install wrk)");
  if (text->find("Non-2xx") != std::string::npos ||
      text->find("Socket errors") != std::string::npos) {
    return fail("wrk: " + *text);
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

/// Both servers in turn, so that what else the machine does falls on both.
Result<json> compare(const Script& script, std::uint16_t ours, std::uint16_t nginx,
                     const StreamOptions& options, std::vector<Bar>& bars) {
  const int rounds = options.quick ? 3 : 9, seconds = options.quick ? 1 : 3;
  std::vector<double> ratios, our_requests, nginx_requests, our_bytes, nginx_bytes;
  for (int round = 0; round < rounds; ++round) {
    const bool first = round % 2 == 0;
    auto one = load(first ? ours : nginx, script, seconds);
    if (!one) return tl::unexpected(one.error());
    auto two = load(first ? nginx : ours, script, seconds);
    if (!two) return tl::unexpected(two.error());
    if (!first) std::swap(*one, *two);
    ratios.push_back(one->requests / two->requests);
    our_requests.push_back(one->requests);
    nginx_requests.push_back(two->requests);
    our_bytes.push_back(one->megabytes);
    nginx_bytes.push_back(two->megabytes);
  }
  const double ratio = median(ratios);
  bars.push_back(
      {fmt::format("HTTP throughput, {}, against nginx", script.about), ratio, "x", 0.9, true});
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
  if (const auto made = make_reel(options.scratch, reel, options.quick ? 8 : 60); !made) {
    return tl::unexpected(made.error());
  }
  std::ifstream in(reel / kManifestName, std::ios::binary);
  const auto manifest = parse_manifest(std::string(std::istreambuf_iterator<char>(in), {}));
  if (!manifest) return tl::unexpected(manifest.error());

  std::vector<std::pair<std::string, std::string>> whole, frames;
  for (const Segment& segment : manifest->segments) {
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
  if (port == 0) return fail("pointreel-server: does not listen");
  const auto nginx = Nginx::start(options.scratch / "nginx", [&](std::uint16_t own) {
    return nginx_configuration("packages.conf",
                               {{"listen 80;", fmt::format("listen 127.0.0.1:{};", own)},
                                {"/srv/pointreel", reels.string()}});
  });
  if (!nginx) return tl::unexpected(nginx.error());

  json figures = {{"connections", kConnections}};
  for (const Script& script :
       {write_script(options.scratch, "segments", "whole layer files", whole),
        write_script(options.scratch, "frames", "single frames", frames)}) {
    auto compared = compare(script, port, (*nginx)->port(), options, bars);
    if (!compared) return tl::unexpected(compared.error());
    figures[script.name] = *std::move(compared);
  }
  return figures;
}

}  // namespace pointreel::bench
