#include <charconv>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "common/base/progress.h"
#include "common/base/stop_signal.h"
#include "pointreel/draco.h"
#include "server/pack/commands.h"
#include "server/pack/encode_arguments.h"
#include "server/pack/packer.h"

namespace pointreel {
namespace {

using nlohmann::ordered_json;

/// The command line as it was given; `make_options` turns it into what it means.
struct PackArguments {
  std::vector<std::string> inputs;
  std::string output;
  SequenceArguments sequence;
  EncodeArguments encode;
  std::string cube = "group";
  std::uint32_t segment = 30;
  std::string bitrate;
  double frame_time_ms = 0.0;
  bool train = false, force = false;
  std::string json;
  CLI::Option *bitrate_option = nullptr, *frame_time_option = nullptr;
  CLI::Option* json_option = nullptr;
};

/// "20M", "800k", "1.5G" or a plain number of bits a second.
Result<double> parse_bitrate(const std::string& text) {
  double rate = 0.0;
  const char* end = text.data() + text.size();
  const auto parsed = std::from_chars(text.data(), end, rate);
  double unit = 1.0;
  if (parsed.ec == std::errc() && end - parsed.ptr == 1) {
    unit = *parsed.ptr == 'k' ? 1e3 : *parsed.ptr == 'M' ? 1e6 : *parsed.ptr == 'G' ? 1e9 : 0.0;
  } else if (parsed.ec != std::errc() || parsed.ptr != end) {
    unit = 0.0;
  }
  rate *= unit;
  if (!(rate >= 1.0 && rate <= 1e15)) {
    return fail("--bitrate " + text +
                ": is no number of bits a second such as 20M, 800k or 1500000");
  }
  return rate;
}

Result<PackOptions> make_options(const PackArguments& arguments) {
  PackOptions options;
  for (const std::string& input : arguments.inputs) options.inputs.emplace_back(input);
  options.output = arguments.output;
  options.name = arguments.sequence.name;
  if (const auto sound = arguments.sequence.check(); !sound) return tl::unexpected(sound.error());
  const Result<EncodeOptions> encode = arguments.encode.options();
  if (!encode) return tl::unexpected(encode.error());
  options.encode = *encode;
  const Result<std::optional<double>> voxel = arguments.encode.voxel();
  if (!voxel) return tl::unexpected(voxel.error());
  options.voxel = *voxel;
  if (arguments.train && arguments.encode.entropy != "context") {
    return fail("--train belongs to --entropy context");
  }
  options.train = arguments.train;
  if (arguments.bitrate_option->count() > 0) {
    const Result<double> bitrate = parse_bitrate(arguments.bitrate);
    if (!bitrate) return tl::unexpected(bitrate.error());
    options.bitrate = *bitrate;
  }
  if (arguments.frame_time_option->count() > 0) {
    if (!(arguments.frame_time_ms > 0.0)) return fail("--frame-time must be above 0");
    options.frame_time_ms = arguments.frame_time_ms;
  }
  options.cube_per_frame = arguments.cube == "frame";
  options.fps = arguments.sequence.fps;
  options.segment_frames = arguments.segment;
  options.up = arguments.sequence.up.front();
  options.threads = arguments.sequence.threads;
  options.force = arguments.force;
  return options;
}

double bits_per_point(std::uint64_t bytes, std::uint64_t points) {
  return points == 0 ? 0.0 : 8.0 * static_cast<double>(bytes) / static_cast<double>(points);
}

ordered_json to_json(const SegmentSummary& segment) {
  ordered_json json = {{"first_frame", segment.first_frame},
                       {"frames", segment.frames},
                       {"bytes", segment.bytes},
                       {"bits_per_second", segment.bits_per_second},
                       {"depth", {{"min", segment.depth_min}, {"max", segment.depth_max}}}};
  if (const auto* octree = std::get_if<OctreeOptions>(&segment.encode.codec)) {
    json["quality"] = octree->color_quality;
    json["normal_quality"] = octree->normal_quality;
  } else {
    json["qn"] = std::get<DracoOptions>(segment.encode.codec).normal_bits;
  }
  json["max_error"] = segment.max_error;
  json["within_bitrate"] = segment.within_rate;
  json["trials"] = segment.trials;
  return json;
}

ordered_json to_json(const PackSummary& summary) {
  const auto bits = [&](std::uint64_t bytes) { return bits_per_point(bytes, summary.points); };
  const std::uint64_t total = summary.geometry_bytes + summary.color_bytes + summary.normal_bytes;
  ordered_json json = {{"frames", summary.frames},
                       {"points", summary.points},
                       {"coded_points", summary.coded_points},
                       {"bytes", summary.bytes},
                       {"bits_per_point",
                        {{"geometry", bits(summary.geometry_bytes)},
                         {"colors", bits(summary.color_bytes)},
                         {"normals", bits(summary.normal_bytes)},
                         {"total", bits(total)}}},
                       {"encode_ms",
                        {{"median", summary.encode_ms.median},
                         {"min", summary.encode_ms.min},
                         {"max", summary.encode_ms.max}}},
                       {"depth", {{"min", summary.depth_min}, {"max", summary.depth_max}}},
                       {"codec", summary.codec}};
  json["entropy"] = nullptr;
  if (!summary.entropy.empty()) json["entropy"] = summary.entropy;
  json["tables"] = nullptr;
  if (summary.learnt) {
    json["tables"] = {{"samples", summary.learnt->samples},
                      {"bytes", summary.learnt->bytes},
                      {"saved_bytes", std::llround(summary.learnt->saved_bytes)}};
  }
  json["max_error"] = summary.max_error;
  json["late_frames"] = summary.late_frames;
  json["segments"] = ordered_json::array();
  for (const SegmentSummary& segment : summary.segments) {
    json["segments"].push_back(to_json(segment));
  }
  json["seconds"] = summary.seconds;
  json["warnings"] = summary.warnings;
  return json;
}

/// What a bit rate made of a segment.
void print_segment(const SegmentSummary& segment) {
  std::string quality;
  if (const auto* octree = std::get_if<OctreeOptions>(&segment.encode.codec)) {
    quality =
        fmt::format("quality {}, of normals {}", octree->color_quality, octree->normal_quality);
  } else {
    quality = fmt::format("qn {}", std::get<DracoOptions>(segment.encode.codec).normal_bits);
  }
  fmt::print("  frames {:>5} to {:>5}  {:.3f} Mbit/s{}, depth {} to {}, {}\n", segment.first_frame,
             segment.first_frame + segment.frames - 1, 1e-6 * segment.bits_per_second,
             segment.within_rate ? "" : " (too much)", segment.depth_min, segment.depth_max,
             quality);
}

void print_summary(const PackArguments& arguments, const PackSummary& summary) {
  const auto bits = [&](std::uint64_t bytes) { return bits_per_point(bytes, summary.points); };
  const std::uint64_t total = summary.geometry_bytes + summary.color_bytes + summary.normal_bytes;
  fmt::print("{}: {} frames, {} points, {} bytes, {:.1f} s\n", arguments.output, summary.frames,
             summary.points, summary.bytes, summary.seconds);
  fmt::print("  bits a point  {:.2f} (geometry {:.2f}, colors {:.2f}, normals {:.2f})\n",
             bits(total), bits(summary.geometry_bytes), bits(summary.color_bytes),
             bits(summary.normal_bytes));
  fmt::print("  encode        {:.2f} ms a frame ({:.2f} to {:.2f})\n", summary.encode_ms.median,
             summary.encode_ms.min, summary.encode_ms.max);
  fmt::print("  codec         {}{}{}, depth {} to {}\n", summary.codec,
             summary.entropy.empty() ? "" : " ", summary.entropy, summary.depth_min,
             summary.depth_max);
  fmt::print("  error         at most {:.4g} of the source's units\n", summary.max_error);
  if (arguments.frame_time_option->count() > 0) {
    fmt::print("  late          {} frames took more than {} ms\n", summary.late_frames,
               arguments.frame_time_ms);
  }
  if (arguments.bitrate_option->count() > 0) {
    for (const SegmentSummary& segment : summary.segments) print_segment(segment);
  }
  if (!summary.learnt) return;
  if (summary.learnt->bytes == 0) {
    fmt::print("  tables        built-in: those learnt from {} frames would save nothing\n",
               summary.learnt->samples);
  } else {
    fmt::print("  tables        learnt from {} frames, {} bytes, which save {:.0f}\n",
               summary.learnt->samples, summary.learnt->bytes, summary.learnt->saved_bytes);
  }
}

int report(const PackArguments& arguments, const PackSummary& summary) {
  if (arguments.json_option->count() == 0) {
    print_summary(arguments, summary);
    return kExitOk;
  }
  const std::string text =
      to_json(summary).dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
  if (arguments.json.empty() || arguments.json == "-") {
    std::fputs(text.c_str(), stdout);
    return kExitOk;
  }
  std::ofstream out(arguments.json, std::ios::binary);
  out << text;
  out.close();
  if (!out) {
    print_error(arguments.json + ": cannot be written (the package is complete)");
    return kExitFailed;
  }
  print_summary(arguments, summary);
  return kExitOk;
}

int run_pack(const PackArguments& arguments) {
  const Result<PackOptions> options = make_options(arguments);
  if (!options) {
    print_error(options.error().message);
    return kExitUsage;
  }
  const StopSignal stop;
  std::unique_ptr<Progress> progress;
  PackListener listener;
  listener.begin = [&](std::uint32_t total) {
    progress = std::make_unique<Progress>("pack", total);
  };
  listener.frame_done = [&] { progress->tick(); };
  listener.warn = [&](const std::string& line) { progress->print("warning: " + line); };
  listener.stop = stop.token();
  const Result<PackSummary> summary = pack(*options, listener);
  progress.reset();
  if (!summary) {
    print_error(summary.error().message);
    return kExitFailed;
  }
  return report(arguments, *summary);
}

}  // namespace

void add_pack_command(CLI::App& app, int& exit_code) {
  const auto arguments = std::make_shared<PackArguments>();
  PackArguments& a = *arguments;
  CLI::App* command = app.add_subcommand("pack", "encode point clouds into a package");
  command->add_option("-i,--input", a.inputs, "folders and .ply or .drc files, in natural order")
      ->required()
      ->expected(1, -1);
  command->add_option("-o,--output", a.output, "the package's folder")->required();
  command->add_option("--cube", a.cube, "what shares a cube")
      ->check(CLI::IsMember({"group", "frame"}))
      ->capture_default_str();
  a.bitrate_option =
      command
          ->add_option(
              "--bitrate", a.bitrate,
              "bits a second that no segment exceeds on average, as 20M or 800k: depth and "
              "quality become what it allows, at most what is asked for")
          ->type_name("RATE");
  a.frame_time_option =
      command
          ->add_option("--frame-time", a.frame_time_ms,
                       "milliseconds to encode a frame in: depth is lowered rather than falling "
                       "behind (other bytes on other machines)")
          ->type_name("MS");
  command->add_option("--segment", a.segment, "frames that share a cube and a file")
      ->check(CLI::Range(1, 100'000))
      ->capture_default_str();
  a.sequence.add_to(*command, "the reel's name instead of its folder's");
  command->add_flag("--force", a.force, "replace a package that is there already");
  a.json_option =
      command->add_option("--json", a.json, "the summary as JSON, in a file or on standard output")
          ->expected(0, 1)
          ->type_name("[FILE]");
  a.encode.add_to(*command);
  a.encode.octree_only.push_back(
      command
          ->add_flag("--train", a.train,
                     "learn the contexts from the frames: smaller, if they are many or noisy")
          ->group("Octree"));
  command->callback([arguments, &exit_code] { exit_code = run_pack(*arguments); });
}

}  // namespace pointreel
