#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "codec/cloud_options/cloud_options.h"
#include "codec/core/write_json.h"
#include "codec/package/manifest.h"
#include "codec/segments/cleaning.h"
#include "codec/segments/coding_error.h"
#include "common/base/words.h"
#include "common/command_line/command.h"
#include "common/net/url.h"
#include "common/process/print.h"
#include "common/process/progress.h"
#include "common/process/stop_signal.h"
#include "server/commands/bit_rates.h"
#include "server/commands/commands.h"
#include "server/commands/package_access.h"
#include "server/commands/sequence_arguments.h"
#include "server/inspect/inspect.h"
#include "server/pack/frame_numbers.h"

namespace pointreel {
namespace {

using nlohmann::ordered_json;

/// What `info` prints in addition to the manifest's own fields.
struct Totals {
  std::uint64_t points = 0, bytes = 0;
  std::uint32_t fewest = std::numeric_limits<std::uint32_t>::max(), most = 0;
  std::vector<std::uint64_t> layer_bytes;
  std::optional<double> max_error;  ///< absent if the frames cannot be read
};

Totals totals_of(const Manifest& manifest) {
  Totals totals;
  totals.layer_bytes.resize(manifest.layer_names.size());
  for (const Segment& segment : manifest.segments) {
    for (const std::uint32_t points : segment.points) {
      totals.points += points;
      totals.fewest = std::min(totals.fewest, points);
      totals.most = std::max(totals.most, points);
    }
    for (std::size_t i = 0; i < segment.layers.size(); ++i) {
      totals.layer_bytes[i] += segment.layers[i].bytes;
      totals.bytes += segment.layers[i].bytes;
    }
  }
  if (manifest.audio) totals.bytes += manifest.audio->bytes;
  if (manifest.tables) totals.bytes += manifest.tables->bytes;
  if (manifest.segments.empty()) totals.fewest = 0;
  return totals;
}

BitRates rates_of(const Manifest& manifest, const Totals& totals) {
  const auto& layers = totals.layer_bytes;
  return bit_rates(std::accumulate(layers.begin(), layers.end(), std::uint64_t{0}),
                   manifest.audio ? manifest.audio->bytes : 0, manifest.duration_us);
}

double audio_seconds(const AudioFile& audio) {
  return static_cast<double>(audio.samples) / kAudioRate;
}

ordered_json info_json(const Manifest& manifest, const Totals& totals) {
  ordered_json layers = ordered_json::array();
  for (std::size_t i = 0; i < manifest.layer_names.size(); ++i) {
    layers.push_back({{"name", manifest.layer_names[i]}, {"bytes", totals.layer_bytes[i]}});
  }
  const auto vector = [](const glm::dvec3& v) { return ordered_json{v.x, v.y, v.z}; };
  ordered_json bounds;
  if (!manifest.bounds.empty()) {
    bounds = {{"min", vector(manifest.bounds.min)}, {"max", vector(manifest.bounds.max)}};
  }
  ordered_json error;
  if (totals.max_error) error = *totals.max_error;
  ordered_json captured, entropy, tables, audio;
  if (manifest.captured_us) captured = *manifest.captured_us;
  if (!manifest.entropy.empty()) entropy = manifest.entropy;
  if (manifest.tables) tables = {{"bytes", manifest.tables->bytes}};
  if (manifest.audio)
    audio = {{"duration_s", audio_seconds(*manifest.audio)}, {"bytes", manifest.audio->bytes}};
  return {{"name", manifest.name},
          {"version", kPackageVersion},
          {"codec", manifest.codec},
          {"entropy", entropy},
          {"frames", manifest.frame_count()},
          {"shown_frames", shown_frames(manifest).size()},
          {"segments", manifest.segments.size()},
          {"fps", manifest.fps},
          {"duration_s", static_cast<double>(manifest.duration_us) * 1e-6},
          {"captured_us", captured},
          {"up", manifest.up.text()},
          {"colors", manifest.colors},
          {"normals", manifest.normals},
          {"scalars", scalars_json(manifest.scalars)},
          {"points", {{"total", totals.points}, {"min", totals.fewest}, {"max", totals.most}}},
          {"depth", {{"min", manifest.depth_min}, {"max", manifest.depth_max}}},
          {"bounds", bounds},
          {"max_error", error},
          {"coding_error", coding_error_json(manifest.coding_error,
                                             manifest.coding_error ? peak_of(manifest) : 0.0)},
          {"cleaning", cleaning_json(manifest.cleaning.value_or(Cleaning{}))},
          {"bytes", totals.bytes},
          {"bits_per_second", bit_rates_json(rates_of(manifest, totals))},
          {"layers", layers},
          {"tables", tables},
          {"audio", audio}};
}

/// To a thousandth of the box's longest edge, also far from zero.
std::string corner_text(const Box& box, const glm::dvec3& corner) {
  const glm::dvec3 extent = box.extent();
  const double longest = std::max({extent.x, extent.y, extent.z});
  const int decimals =
      longest > 0.0 ? std::clamp(3 - static_cast<int>(std::floor(std::log10(longest))), 0, 15) : 0;
  const auto text = [&](double number) {
    const int whole = std::abs(number) >= 1.0
                          ? 1 + static_cast<int>(std::floor(std::log10(std::abs(number))))
                          : 1;
    return number_text(number, std::clamp(whole + decimals, 6, 15));
  };
  return fmt::format("({}, {}, {})", text(corner.x), text(corner.y), text(corner.z));
}

void print_info(const Manifest& manifest, const Totals& totals) {
  const double seconds = static_cast<double>(manifest.duration_us) * 1e-6;
  const std::uint32_t frames = manifest.frame_count();
  const std::size_t shown = shown_frames(manifest).size();
  print("{}: {}{}, {:.2f} s at {} fps, {}, up {}\n", manifest.name, counted(frames, "frame"),
        shown == frames ? "" : fmt::format(" ({} of them shown)", shown), seconds,
        number_text(manifest.fps), counted(manifest.segments.size(), "segment"),
        manifest.up.text());
  if (manifest.captured_us) {
    const auto unix_seconds = static_cast<std::time_t>(*manifest.captured_us / 1'000'000);
    print("  captured {:%Y-%m-%d %H:%M:%S} UTC\n", fmt::gmtime(unix_seconds));
  }
  print("  codec   {}{}{}, depth {}\n", manifest.codec, manifest.entropy.empty() ? "" : " ",
        manifest.entropy, span_text(manifest.depth_min, manifest.depth_max));
  print("  points  {} in the source ({} per frame), colors {}, normals {}\n", totals.points,
        span_text(totals.fewest, totals.most), manifest.colors ? "yes" : "no",
        !manifest.normals            ? "no"
        : manifest.normals_estimated ? "estimated"
                                     : "yes");
  for (const ScalarRange& range : manifest.scalars) {
    print("  scalar  {}, {} to {}{}\n", range.name, number_text(range.least),
          number_text(range.most), range.labels ? ", labels" : "");
  }
  if (!manifest.bounds.empty()) {
    print("  bounds  {} to {}\n", corner_text(manifest.bounds, manifest.bounds.min),
          corner_text(manifest.bounds, manifest.bounds.max));
  }
  if (totals.max_error) {
    print("  error   at most {}, in the source's units\n", number_text(*totals.max_error, 4));
  }
  if (manifest.coding_error)
    print("  compared {}\n", coding_error_text(*manifest.coding_error, peak_of(manifest)));
  if (manifest.cleaning) print("  cleaned {}\n", cleaning_text(*manifest.cleaning));
  print("  bytes   {}", totals.bytes);
  if (seconds > 0.0) print(", {}", bit_rates_text(rates_of(manifest, totals)));
  print("\n");
  for (std::size_t i = 0; i < manifest.layer_names.size(); ++i) {
    print("    {:8} {}\n", manifest.layer_names[i], totals.layer_bytes[i]);
  }
  if (manifest.tables) print("    {:8} {}\n", "tables", manifest.tables->bytes);
  if (!manifest.audio) return;
  print("    {:8} {}, {} s\n", "audio", manifest.audio->bytes,
        number_text(audio_seconds(*manifest.audio)));
}

int run_info(const std::string& reel, bool json, const PackageAccess& access) {
  const Result<PackageFiles> files = access.open(reel);
  if (!files) return failed_to_open(files.error());
  const Result<Manifest> manifest = files->manifest();
  if (!manifest) return failed_to_open(manifest.error());
  Totals totals = totals_of(*manifest);
  totals.max_error = manifest->max_error;
  // Of what is far away, no files are fetched to find out.
  if (!files->remote() && manifest->group_frames == 0) {
    if (const Result<double> error = max_error(*files, *manifest)) totals.max_error = *error;
  }
  if (json) {
    print_json(info_json(*manifest, totals));
  } else {
    print_info(*manifest, totals);
  }
  return kExitOk;
}

/// A listener that shows a progress bar. `progress` and `stop` must outlive it.
InspectListener listener_for(const char* label, std::unique_ptr<Progress>& progress,
                             const StopSignal& stop) {
  InspectListener listener;
  listener.begin = [label, &progress](std::uint32_t total) {
    progress = std::make_unique<Progress>(label, total);
  };
  listener.frame_done = [&progress] { progress->tick(); };
  listener.stop = stop.token();
  return listener;
}

/// One for each file, and for each run of frames with the same fault. Frames of a file that cannot
/// be read have its fault, which is told once.
std::vector<std::string> fault_lines(const std::vector<Fault>& faults) {
  std::vector<std::string> lines;
  std::set<std::pair<std::string, std::string>> of_files;
  for (std::size_t i = 0; i < faults.size();) {
    const Fault& first = faults[i++];
    if (!first.frame) {
      of_files.emplace(first.file, first.what);
      lines.push_back(fmt::format("{}: {}", first.file, first.what));
      continue;
    }
    std::uint32_t last = *first.frame;
    while (i < faults.size() && faults[i].frame == last + 1 && faults[i].file == first.file &&
           faults[i].what == first.what) {
      ++last;
      ++i;
    }
    if (of_files.contains({first.file, first.what})) continue;
    lines.push_back(fmt::format("{}: {} {}: {}", first.file,
                                last == *first.frame ? "frame" : "frames",
                                span_text(*first.frame, last), first.what));
  }
  return lines;
}

ordered_json verify_json(const VerifyReport& report) {
  ordered_json faults = ordered_json::array();
  for (const Fault& fault : report.faults) {
    ordered_json frame;
    if (fault.frame) frame = *fault.frame;
    faults.push_back({{"file", fault.file}, {"frame", frame}, {"what", fault.what}});
  }
  return {{"good", report.faults.empty()},
          {"frames", report.frames},
          {"files", report.files},
          {"bytes", report.bytes},
          {"faults", faults}};
}

int run_verify(const std::string& reel, bool json, std::uint64_t max_memory,
               const PackageAccess& access) {
  const StopSignal stop;
  const Result<PackageFiles> files = access.open(reel, stop.token());
  if (!files) return failed_to_open(files.error());
  if (const Result<Manifest> manifest = files->manifest(); !manifest) {
    return failed_to_open(manifest.error());
  }
  std::unique_ptr<Progress> progress;
  const Result<VerifyReport> report =
      verify(*files, listener_for("verify", progress, stop), max_memory);
  progress.reset();
  if (!report) {
    print_error(report.error().message);
    return kExitFailed;
  }
  if (json) {
    print_json(verify_json(*report));
  } else if (report->faults.empty()) {
    print("{}: OK, {} in {}, {}\n", files->shown(), counted(report->frames, "frame"),
          counted(report->files, "file"), counted(report->bytes, "byte"));
  } else {
    const std::vector<std::string> lines = fault_lines(report->faults);
    for (const std::string& line : lines) print("{}\n", line);
    print("{}: {}\n", files->shown(), counted(lines.size(), "fault"));
  }
  return report->faults.empty() ? kExitOk : kExitFailed;
}

/// What LAS files did not keep, in one line.
std::string describe_lost(const std::vector<LostValues>& lost) {
  std::string parts;
  for (const LostValues& one : lost) {
    if (!parts.empty()) parts += ", ";
    parts += fmt::format(
        "{} of {} {}", counted(one.values, "value"), one.field,
        one.bounds ? fmt::format("clipped to {} to {}", one.bounds->first, one.bounds->second)
                   : "dropped");
  }
  return fmt::format("LAS cannot hold all scalar fields: {}; ply, pcd, npz and mcap can", parts);
}

int run_unpack(UnpackOptions options, const std::string& frames, const std::string& input,
               const PackageAccess& access) {
  if (!frames.empty()) {
    const auto range = parse_frame_numbers(frames);
    if (!range) {
      print_error(fault_of_frame_numbers(frames));
      return kExitUsage;
    }
    options.first_frame = range->first;
    options.last_frame = range->second;
  }
  const StopSignal stop;
  const Result<PackageFiles> files = access.open(input, stop.token());
  if (!files) return failed_to_open(files.error());
  options.input = *files;
  const Result<Manifest> manifest = files->manifest();
  if (!manifest) return failed_to_open(manifest.error());
  std::unique_ptr<Progress> progress;
  const Result<UnpackReport> report = unpack(options, listener_for("unpack", progress, stop));
  progress.reset();
  if (!report) return failed_to_open(report.error());
  print("{}: {}{}\n", options.output.string(), counted(report->frames, "frame"),
        options.mesh ? ", " + counted(report->triangles, "triangle") : "");
  if (const bool takes_z =
          options.recording || (!options.mesh && options.format == PointsFormat::las);
      takes_z && manifest->up != Up('z')) {
    print_error(
        fmt::format("the axes stay as they are: {0} points up, but readers of {1} files take "
                    "z; to pack what was unpacked, give --up {0}",
                    manifest->up.text(), options.recording ? "MCAP" : "LAS"));
  }
  if (!report->lost.empty()) print_error(describe_lost(report->lost));
  if (report->without_mesh > 0) {
    const bool one = report->without_mesh == 1;
    print_error(fmt::format("{} of {} {} points but no surface, so {} empty", report->without_mesh,
                            counted(report->frames, "frame"), one ? "has" : "have",
                            one ? "its mesh is" : "their meshes are"));
  }
  return kExitOk;
}

std::optional<MeshFormat> mesh_format_of(const std::string& word) {
  if (word == "ply") return MeshFormat::ply;
  if (word == "obj") return MeshFormat::obj;
  if (word == "glb") return MeshFormat::glb;
  return std::nullopt;
}

std::optional<PointsFormat> points_format_of(const std::string& word) {
  for (const PointsFormat format :
       {PointsFormat::ply, PointsFormat::pcd, PointsFormat::las, PointsFormat::npz}) {
    if (extension(format) == "." + word) return format;
  }
  return std::nullopt;
}

void add_unpack_command(cli::Command app, int& exit_code) {
  struct Arguments {
    std::string input, output, frames;
    PackageAccess access;
    std::uint64_t frame_memory = 0;
    std::uint32_t layers = 0;
    bool force = false;
    bool mesh = false, animation = false, voxels = false;
    std::optional<double> cell;
    std::optional<std::size_t> triangles;
    std::string format = "ply";
  };
  const auto a = std::make_shared<Arguments>();
  const cli::Command unpack =
      app.add_subcommand("unpack", "Decode a package into files of points or meshes");
  unpack.add_option("-i,--input,REEL", a->input, "the folder or the address of the package")
      .required()
      .type_name("REEL");
  unpack
      .add_option("-o,--output,FOLDER", a->output,
                  "the folder in which frame_00000.ply, ... are written")
      .required()
      .type_name("FOLDER");
  const cli::Option layers =
      unpack
          .add_option("--layers", a->layers,
                      "decode only this many layers, from the base (default: all)")
          .check(cli::range(1, 255));
  unpack
      .add_option("--frames", a->frames,
                  "decode only frames A to B, including both, or only frame A, numbered from 0 "
                  "among those that are shown")
      .check(cli::not_empty("frames"))
      .type_name("A-B");
  add_frame_memory_option(unpack, a->frame_memory);
  a->access.add_to(unpack);
  unpack.add_flag("--voxels", a->voxels,
                  "of video: write the voxels that the surface crosses, instead of its points");
  const cli::Option mesh = unpack.add_flag(
      "--mesh", a->mesh, "make a surface of triangles from the points of each frame");
  unpack
      .add_option("--format", a->format,
                  "of points: ply, pcd, las, npz (numpy) or mcap (one ROS 2 recording of all "
                  "frames); of meshes: ply, obj or glb, which is binary glTF")
      .check(cli::one_of({"ply", "pcd", "las", "npz", "mcap", "obj", "glb"}))
      .capture_default_str();
  unpack
      .add_flag("--animation", a->animation,
                "write one file, animation.glb, which plays all frames; needs --format glb")
      .needs(mesh);
  unpack
      .add_option("--cell", a->cell,
                  "the edge of the cells in which a mesh follows the surface, in the units of the "
                  "source; edges of triangles are about as long (default: 1.5 times the spacing of "
                  "the points)")
      .check(cli::positive_number())
      .type_name("LENGTH")
      .needs(mesh);
  unpack
      .add_option("--triangles", a->triangles,
                  "reduce each mesh to this many triangles, or as far as its shape allows "
                  "(default: all)")
      .check(cli::range(std::size_t{1}, std::size_t{1} << 30))
      .type_name("N")
      .needs(mesh);
  unpack.add_flag("--force", a->force, "replace a folder of unpacked frames that is already there");
  unpack.callback([a, layers, &exit_code] {
    UnpackOptions options;
    options.output = a->output;
    options.force = a->force;
    options.voxels = a->voxels;
    options.max_memory = a->frame_memory << 20;
    if (layers.count() > 0) options.layers = a->layers;
    const auto mesh_format = mesh_format_of(a->format);
    const auto points_format = points_format_of(a->format);
    options.recording = a->format == "mcap";
    if (a->mesh ? !mesh_format : !points_format && !options.recording) {
      print_error(a->mesh ? fmt::format("--format {}: holds points; leave out --mesh", a->format)
                          : fmt::format("--format {}: holds meshes; add --mesh", a->format));
      exit_code = kExitUsage;
      return;
    }
    if (points_format) options.format = *points_format;
    if (a->animation && mesh_format != MeshFormat::glb) {
      print_error("--animation: only .glb files can hold one; add --format glb");
      exit_code = kExitUsage;
      return;
    }
    if (a->mesh) {
      options.mesh = UnpackMesh{.format = *mesh_format,
                                .options = {.cell = a->cell, .triangles = a->triangles},
                                .animation = a->animation};
    }
    exit_code = run_unpack(options, a->frames, a->input, a->access);
  });
}

}  // namespace

void add_inspect_commands(cli::Command app, int& exit_code) {
  struct Arguments {
    std::string reel;
    bool json = false;
    std::uint64_t frame_memory = 0;
    PackageAccess access;
  };
  const auto add = [&](const char* name, const char* what, const std::shared_ptr<Arguments>& a) {
    const cli::Command command = app.add_subcommand(name, what);
    command
        .add_option("-i,--input,REEL", a->reel,
                    "the folder of the package, or its address: http://, https:// or s3://")
        .required()
        .type_name("REEL");
    a->access.add_to(command);
    command.add_flag("--json", a->json, "print JSON");
    return command;
  };
  const auto a = std::make_shared<Arguments>();
  add("info", "Show what a package contains", a).callback([a, &exit_code] {
    exit_code = run_info(a->reel, a->json, a->access);
  });
  const cli::Command verify =
      add("verify", "Check every file of a package and decode every frame", a);
  add_frame_memory_option(verify, a->frame_memory);
  verify.callback([a, &exit_code] {
    exit_code = run_verify(a->reel, a->json, a->frame_memory << 20, a->access);
  });
  add_unpack_command(app, exit_code);
}

}  // namespace pointreel
