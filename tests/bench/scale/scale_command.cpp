#include "tests/bench/scale/scale_command.h"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "codec/package/manifest.h"
#include "common/base/try.h"
#include "common/process/print.h"
#include "pointreel/package.h"
#include "tests/bench/output.h"
#include "tests/bench/scale/edges.h"
#include "tests/bench/scale/request_log.h"
#include "tests/bench/table.h"

namespace pointreel::bench {
namespace {

using nlohmann::json;

struct Options {
  std::filesystem::path reel;
  std::vector<std::filesystem::path> logs;
  double log_rate = 30.0, pack_ms = 0.0;
  std::vector<double> cache_gigabytes = {1.0, 10.0, 100.0, 1000.0};
  PlannedReel planned;
  Audience audience;
  EdgeCaches edges;
  std::string json;
};

std::vector<double> frame_bytes_of(const Manifest& manifest) {
  std::vector<double> bytes(manifest.layer_names.size());
  for (const Segment& segment : manifest.segments)
    for (std::size_t layer = 0; layer < segment.layers.size(); ++layer)
      bytes[layer] += static_cast<double>(segment.layers[layer].bytes) / manifest.frame_count();
  return bytes;
}

void print_store(const Options& options, double points, double manifest_bytes) {
  const PlannedReel& reel = options.planned;
  const double frames = 3600.0 * reel.hours * reel.frame_rate;
  double bytes = 0.0;
  for (const double layer : reel.frame_bytes) bytes += layer;
  print("{:g} hours of {:g} frames a second with {:.0f} points: {:.0f} frames\n", reel.hours,
        reel.frame_rate, points, frames);
  if (options.pack_ms > 0.0)
    print("  to pack     {:.0f} core hours, at {:g} ms a frame\n", frames * options.pack_ms / 3.6e6,
          options.pack_ms);
  print("  to store    {:.1f} GB, {:.0f} Mbit/s while it plays\n", 1e-9 * frames * bytes,
        8e-6 * bytes * reel.frame_rate);
  print("  manifests   {:.1f} MB; readers accept {:.1f} MB, which is {:.1f} hours of such frames\n",
        1e-6 * frames * manifest_bytes, 1e-6 * static_cast<double>(kMaxManifestBytes),
        static_cast<double>(kMaxManifestBytes) / manifest_bytes / reel.frame_rate / 3600.0);
}

json to_json(double gigabytes, const EdgeFigures& figures) {
  return {{"cache_gigabytes", gigabytes},
          {"requests", figures.requests},
          {"bytes", figures.bytes},
          {"store_requests", figures.store_requests},
          {"store_bytes", figures.store_bytes},
          {"most_requests_per_second", figures.most_requests},
          {"most_bytes_per_second", figures.most_bytes},
          {"most_store_bytes_per_second", figures.most_store_bytes}};
}

Result<void> run_scale(Options& options) {
  const Manifest manifest = TRY(read_manifest(options.reel));
  if (manifest.frame_count() == 0) return fail(options.reel.string() + ": has no frames");
  const double frames = manifest.frame_count();
  options.planned.frame_bytes = frame_bytes_of(manifest);
  double points = 0.0;
  for (const Segment& segment : manifest.segments)
    for (const std::uint32_t count : segment.points) points += count / frames;
  const double manifest_bytes =
      static_cast<double>(std::filesystem::file_size(options.reel / kManifestName)) / frames;
  std::vector<Trace> traces;
  for (const std::filesystem::path& log : options.logs)
    traces.push_back(TRY(read_request_log(log)));
  print_store(options, points, manifest_bytes);

  print("{} viewers, each for {:g} s, who come within {:g} s; {} edges\n\n",
        grouped(options.audience.viewers), options.audience.session_seconds,
        options.audience.arrival_seconds, options.edges.count);
  Table table({"cache of an edge", "to viewers", "at most", "requests a second, at most",
               "from the store", "at most", "fetches", "bytes that edges had",
               "requests that edges had"});
  json rows = json::array();
  for (const double gigabytes : options.cache_gigabytes) {
    options.edges.bytes_each = static_cast<std::uint64_t>(1e9 * gigabytes);
    const EdgeFigures figures =
        simulate(options.planned, options.audience, options.edges, traces, options.log_rate);
    table.row({fmt::format("{:g} GB", gigabytes), fmt::format("{:.0f} TB", 1e-12 * figures.bytes),
               fmt::format("{:.0f} Gbit/s", 8e-9 * figures.most_bytes),
               fmt::format("{:.1f} million", 1e-6 * figures.most_requests),
               fmt::format("{:.1f} TB", 1e-12 * figures.store_bytes),
               fmt::format("{:.0f} Gbit/s", 8e-9 * figures.most_store_bytes),
               fmt::format("{:.1f} million", 1e-6 * figures.store_requests),
               fmt::format("{:.1f} %", 100.0 * (1.0 - figures.store_bytes / figures.bytes)),
               fmt::format("{:.2f} %", 100.0 * (1.0 - figures.store_requests / figures.requests))});
    rows.push_back(to_json(gigabytes, figures));
  }
  print_lines(table.text());
  if (options.json.empty()) return {};
  return write_json(options.json, {{"benchmark", "scale"},
                                   {"frame_bytes", options.planned.frame_bytes},
                                   {"points", points},
                                   {"edges", rows}});
}

}  // namespace

void add_scale_command(cli::Command app, int& exit_code) {
  const cli::Command command = app.add_subcommand(
      "scale",
      "computes what a long reel costs to pack, to store, and to deliver to many viewers through "
      "caches, by repeating what real viewers asked for");
  const auto options = std::make_shared<Options>();
  command.add_option("REEL", options->reel, "the package whose frames the long reel has")
      .required();
  command
      .add_option("LOG", options->logs,
                  "what pointreel-server serve --log info wrote while one viewer watched; each "
                  "viewer repeats one of them")
      .required();
  command.add_option("--log-rate", options->log_rate, "frames per second of what they watched")
      .check(cli::range(1.0, 1000.0))
      .capture_default_str();
  command
      .add_option("--pack-ms", options->pack_ms,
                  "processor time that packing a frame takes, in milliseconds")
      .check(cli::range(0.0, 1e9));
  command.add_option("--hours", options->planned.hours, "length of the long reel")
      .check(cli::range(0.01, 1000.0))
      .capture_default_str();
  command.add_option("--fps", options->planned.frame_rate, "its frames per second")
      .check(cli::range(1.0, 1000.0))
      .capture_default_str();
  command.add_option("--viewers", options->audience.viewers, "how many watch")
      .check(cli::range(1u, 10'000'000u))
      .capture_default_str();
  command
      .add_option("--arrival", options->audience.arrival_seconds, "they come within these seconds")
      .check(cli::range(0.0, 1e6))
      .capture_default_str();
  command
      .add_option("--session", options->audience.session_seconds,
                  "for how many seconds each watches")
      .check(cli::range(1.0, 1e6))
      .capture_default_str();
  command
      .add_option("--from-start", options->audience.from_start,
                  "the share that begins at the start; the others begin anywhere")
      .check(cli::range(0.0, 1.0))
      .capture_default_str();
  command.add_option("--edges", options->edges.count, "number of caches between viewers and store")
      .check(cli::range(1u, 10'000u))
      .capture_default_str();
  command
      .add_option("--cache-gb", options->cache_gigabytes, "sizes of each cache to compute, in GB")
      .check(cli::range(0.001, 1e6));
  command.add_option("--json", options->json,
                     "also write the figures to this file; - is standard output");
  command.callback([options, &exit_code] {
    const auto done = run_scale(*options);
    if (done) return;
    print_error("pointreel-bench", done.error().message);
    exit_code = 1;
  });
}

}  // namespace pointreel::bench
