#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "codec/segments/cleaning.h"
#include "codec/segments/coding_error.h"
#include "common/base/words.h"
#include "common/file_system/scratch_folder.h"
#include "common/file_system/write_file.h"
#include "common/process/print.h"
#include "common/process/stop_signal.h"
#include "server/commands/bit_rates.h"
#include "server/commands/commands.h"
#include "server/commands/pack_arguments.h"
#include "server/commands/pack_progress.h"
#include "server/commands/parts_commands.h"
#include "server/commands/report_upload.h"
#include "server/commands/store_options.h"
#include "server/pack/packer.h"
#include "server/pack/video_trial.h"
#include "server/store/upload.h"

namespace pointreel {
namespace {

using nlohmann::ordered_json;

struct PackCommand {
  PackArguments pack;
  UploadOptions upload;  ///< nothing is uploaded if `to` is empty
  std::string json;
  cli::Option json_option;
};

double bits_per_point(std::uint64_t bytes, const PackSummary& summary) {
  if (summary.points == 0) return 0.0;
  return 8.0 * static_cast<double>(bytes) / static_cast<double>(summary.points);
}

BitRates rates_of(const PackSummary& summary) {
  return bit_rates(summary.segment_bytes, summary.audio ? summary.audio->file.bytes : 0,
                   summary.duration_us);
}

ordered_json to_json(const SegmentSummary& segment) {
  ordered_json json = {{"first_frame", segment.first_frame},
                       {"frames", segment.frames},
                       {"bytes", segment.bytes},
                       {"bits_per_second", segment.bits_per_second},
                       {"depth", {{"min", segment.depth_min}, {"max", segment.depth_max}}}};
  if (segment.video_quality) {
    json["quality"] = *segment.video_quality;
  } else if (const auto* octree = std::get_if<OctreeOptions>(&segment.encode.codec)) {
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

ordered_json to_json(const EncodedAudio& audio) {
  ordered_json source;
  if (audio.source_us) source = 1e-6 * static_cast<double>(*audio.source_us);
  return {{"duration_s", static_cast<double>(audio.file.samples) / kAudioRate},
          {"bytes", audio.file.bytes},
          {"source_s", source},
          {"cut_off", audio.cut_off}};
}

ordered_json to_json(const PackSummary& summary) {
  ordered_json bits;
  if (summary.parts) {
    bits["geometry"] = bits_per_point(summary.parts->geometry, summary);
    bits["colors"] = bits_per_point(summary.parts->colors, summary);
    bits["normals"] = bits_per_point(summary.parts->normals, summary);
  }
  if (summary.scalar_bytes > 0) bits["scalars"] = bits_per_point(summary.scalar_bytes, summary);
  bits["total"] = bits_per_point(summary.segment_bytes, summary);
  ordered_json json = {{"frames", summary.frames},
                       {"points", summary.points},
                       {"coded_points", summary.coded_points},
                       {"bytes", summary.bytes},
                       {"duration_s", 1e-6 * static_cast<double>(summary.duration_us)},
                       {"bits_per_second", bit_rates_json(rates_of(summary))},
                       {"bits_per_point", std::move(bits)},
                       {"encode_ms",
                        {{"median", summary.encode_ms.median},
                         {"min", summary.encode_ms.min},
                         {"max", summary.encode_ms.max}}},
                       {"depth", {{"min", summary.depth_min}, {"max", summary.depth_max}}},
                       {"codec", summary.codec}};
  json["audio"] = nullptr;
  if (summary.audio) json["audio"] = to_json(*summary.audio);
  json["entropy"] = nullptr;
  if (!summary.entropy.empty()) json["entropy"] = summary.entropy;
  json["tables"] = nullptr;
  if (summary.learnt) {
    json["tables"] = {{"samples", summary.learnt->samples},
                      {"bytes", summary.learnt->bytes},
                      {"saved_bytes", std::llround(summary.learnt->saved_bytes)}};
  }
  json["normals_estimated"] = summary.normals_estimated;
  json["codec_trial"] = trial_json(summary.trial);
  json["cleaning"] = cleaning_json(summary.cleaning);
  json["recorded_fps"] = nullptr;
  if (summary.recorded_fps) json["recorded_fps"] = *summary.recorded_fps;
  json["max_error"] = nullptr;
  if (!summary.video) json["max_error"] = summary.max_error;
  json["coding_error"] = coding_error_json(summary.coding_error, summary.peak);
  json["late_frames"] = summary.late_frames;
  json["read_as"] = summary.guesses;
  json["missing"] = {{"frames", summary.unreadable_frames}, {"parts", summary.lost_parts}};
  json["segments"] = ordered_json::array();
  for (const SegmentSummary& segment : summary.segments) {
    json["segments"].push_back(to_json(segment));
  }
  json["seconds"] = summary.seconds;
  json["warnings"] = summary.warnings;
  return json;
}

/// The last part of an address.
std::string name_in(std::string address) {
  while (address.ends_with('/')) address.pop_back();
  return address.substr(address.rfind('/') + 1);
}

/// What the bit rate allowed for a segment.
void print_segment(const SegmentSummary& segment) {
  std::string quality;
  if (segment.video_quality) {
    quality = fmt::format("quality {}", *segment.video_quality);
  } else if (const auto* octree = std::get_if<OctreeOptions>(&segment.encode.codec)) {
    quality =
        fmt::format("quality {}, of normals {}", octree->color_quality, octree->normal_quality);
  } else {
    quality = fmt::format("qn {}", std::get<DracoOptions>(segment.encode.codec).normal_bits);
  }
  print("  frames {:>5} to {:>5}  {:.3f} Mbit/s{}, depth {}, {}\n", segment.first_frame,
        segment.first_frame + segment.frames - 1, 1e-6 * segment.bits_per_second,
        segment.within_rate ? "" : " (too much)", span_text(segment.depth_min, segment.depth_max),
        quality);
}

/// `package`: where it is.
void print_summary(const std::string& package, const PackOptions& options,
                   const PackSummary& summary) {
  print("{}: {}, {}, {}, {:.1f} s\n", package, counted(summary.frames, "frame"),
        counted(summary.points, "point"), counted(summary.bytes, "byte"), summary.seconds);
  print("  bit rate        {}\n", bit_rates_text(rates_of(summary)));
  print("  bits per point  {:.2f}", bits_per_point(summary.segment_bytes, summary));
  if (summary.parts) {
    print(" (geometry {:.2f}, colors {:.2f}, normals {:.2f})",
          bits_per_point(summary.parts->geometry, summary),
          bits_per_point(summary.parts->colors, summary),
          bits_per_point(summary.parts->normals, summary));
  }
  if (summary.scalar_bytes > 0)
    print(", scalar fields {:.2f}", bits_per_point(summary.scalar_bytes, summary));
  print("\n");
  if (summary.audio) print("  sound           {}\n", encoded_audio_text(*summary.audio));
  print("  encode          {:.2f} ms per frame ({:.2f} to {:.2f})\n", summary.encode_ms.median,
        summary.encode_ms.min, summary.encode_ms.max);
  print("  codec           {}{}{}, depth {}\n", summary.codec, summary.entropy.empty() ? "" : " ",
        summary.entropy, span_text(summary.depth_min, summary.depth_max));
  if (summary.trial)
    for (const std::string& line : trial_lines(*summary.trial)) print("{}\n", line);
  if (options.video_if_it_pays && summary.frames < kFewestVideoFrames &&
      summary.scalar_bytes == 0 && summary.points >= kFewestVideoPoints * summary.frames)
    print("  video           not tried on fewer than {} frames (--codec video packs it anyway)\n",
          kFewestVideoFrames);
  if (summary.normals_estimated)
    print("  normals         estimated, since the source has none (--normals overrides)\n");
  if (!summary.video)
    print("  error           at most {}, in the source's units\n",
          number_text(summary.max_error, 4));
  if (summary.coding_error)
    print("  compared        {}\n", coding_error_text(*summary.coding_error, summary.peak));
  if (summary.cleaning.frames > 0) {
    print("  cleaning        {}\n", cleaning_text(summary.cleaning));
  } else if (!summary.not_cleaned.empty()) {
    print("  cleaning        none: {}\n", why_not_cleaned(*options.clean, summary.not_cleaned));
  }
  if (summary.recorded_fps) {
    print(
        "  time            as recorded, {} frames per second by the median (--fps spaces them "
        "evenly)\n",
        number_text(*summary.recorded_fps, 4));
  }
  for (const std::string& guess : summary.guesses) print("  read as         {}\n", guess);
  if (summary.unreadable_frames + summary.lost_parts > 0) {
    print("  missing         {}{}\n",
          summary.unreadable_frames == 0 ? ""
                                         : fmt::format("{}, in whose place others are shown{}",
                                                       counted(summary.unreadable_frames, "frame"),
                                                       summary.lost_parts == 0 ? "" : "; "),
          summary.lost_parts == 0 ? ""
                                  : counted(summary.lost_parts, "damaged part") + " of recordings");
  }
  if (options.frame_time_ms) {
    print("  late            {} took longer than {} ms\n", counted(summary.late_frames, "frame"),
          number_text(*options.frame_time_ms));
  }
  if (options.bitrate) {
    for (const SegmentSummary& segment : summary.segments) print_segment(segment);
  }
  if (!summary.learnt) return;
  if (summary.learnt->bytes == 0) {
    print("  tables          built-in; tables learnt from {} would save nothing\n",
          counted(summary.learnt->samples, "frame"));
  } else {
    print("  tables          learnt from {}; after their own {} they save about {:.0f}\n",
          counted(summary.learnt->samples, "frame"), counted(summary.learnt->bytes, "byte"),
          summary.learnt->saved_bytes);
  }
}

/// `package`: where it is.
int report(const PackCommand& arguments, const std::string& package, const PackOptions& options,
           const PackSummary& summary, const std::optional<UploadSummary>& uploaded) {
  const std::string& to = arguments.upload.to;
  const auto print_text = [&] {
    print_summary(package, options, summary);
    if (uploaded) print("{}\n", upload_text(to, *uploaded));
  };
  if (arguments.json_option.count() == 0) {
    print_text();
    return kExitOk;
  }
  ordered_json json = to_json(summary);
  if (uploaded) json["upload"] = upload_json(to, *uploaded);
  if (arguments.json.empty() || arguments.json == "-") {
    print_json(json);
    return kExitOk;
  }
  const std::string text = json.dump(2, ' ', true, ordered_json::error_handler_t::replace) + "\n";
  if (const auto written = write_file(arguments.json, text); !written) {
    print_error(written.error().message + " (the package is complete)");
    return kExitFailed;
  }
  print_text();
  return kExitOk;
}

int fail_with(const Error& error) {
  print_error(error.message);
  return error.code == ErrorCode::argument ? kExitUsage : kExitFailed;
}

/// Whether a file lies in a folder, or would.
bool lies_in(const std::filesystem::path& file, const std::filesystem::path& folder) {
  std::error_code ignored;
  const auto above = std::filesystem::weakly_canonical(file, ignored).parent_path();
  return !folder.empty() && above == std::filesystem::weakly_canonical(folder, ignored);
}

/// --json takes the word that follows it, which may have been meant as a path. It must not lie
/// among what is read and written.
Result<void> check_json(const std::string& file, const PackOptions& options) {
  if (!file.empty() && file != "-") {
    std::vector<std::filesystem::path> folders = options.inputs;
    folders.push_back(options.output);
    for (const std::filesystem::path& folder : folders)
      if (lies_in(file, folder))
        return fail(ErrorCode::argument, fmt::format("--json {}: lies in {}; name a file elsewhere",
                                                     file, folder.string()));
  }
  if (file.empty() || file == "-" || !std::filesystem::exists(file)) return {};
  char first = '{';
  std::ifstream(file).get(first);
  if (std::filesystem::is_regular_file(file) && first == '{') return {};
  return fail(
      ErrorCode::argument,
      fmt::format("--json {}: already exists and is not JSON; put --json at the end", file));
}

int run_pack(const PackCommand& arguments) {
  Result<PackOptions> options = arguments.pack.options_with_paths(arguments.upload.to.empty());
  if (!options) {
    print_error(options.error().message);
    return kExitUsage;
  }
  if (const auto checked = check_json(arguments.json, *options); !checked) {
    print_error(checked.error().message);
    return kExitUsage;
  }
  const StopSignal stop;
  std::optional<Uploader> uploader;
  ScratchFolder temporary;
  const bool kept = !options->output.empty();
  if (!arguments.upload.to.empty()) {
    UploadOptions upload = arguments.upload;
    upload.http.stop = stop.token();
    upload.force = options->force;
    Result<Uploader> opened = Uploader::open(upload);
    if (!opened) return fail_with(opened.error());
    uploader = std::move(*opened);
    if (!kept) {
      const Result<std::filesystem::path> folder = temporary.path(
          ": cannot be created; set TMPDIR to a folder that has room, or keep the package with -o");
      if (!folder) return fail_with(folder.error());
      options->output = *folder / name_in(upload.to);
    }
  }
  PackProgress progress;
  const Result<PackSummary> summary = pack(*options, progress.listener(stop.token()));
  progress.done();
  if (!summary) return failed(summary.error());
  std::optional<UploadSummary> uploaded;
  if (uploader) {
    const Result<UploadSummary> sent = upload_with_progress(*uploader, options->output);
    if (!sent) {
      const int code = fail_with(sent.error());
      if (sent.error().code != ErrorCode::argument && kept)
        print_error(fmt::format("{}: is complete; pointreel-server upload goes on from here",
                                options->output.string()));
      return code;
    }
    uploaded = *sent;
  }
  return report(arguments, kept ? options->output.string() : arguments.upload.to, *options,
                *summary, uploaded);
}

}  // namespace

void add_pack_command(cli::Command app, int& exit_code) {
  const auto arguments = std::make_shared<PackCommand>();
  const cli::Command command = app.add_subcommand("pack", "Encode point clouds into a package");
  arguments->pack.add_to(command);
  arguments->json_option =
      command
          .add_option("--json", arguments->json, "print the summary as JSON, or write it to FILE")
          .expected(0, 1)
          .type_name("[FILE]");
  arguments->upload.http = patient_http_options();
  command
      .add_option_function<std::string>(
          "--to", [arguments](const std::string& to) { arguments->upload.to = to; },
          "upload the package to an object store, s3://BUCKET/REEL; with -o, keep a local copy, "
          "too. Files that are there already are not sent again")
      .type_name("ADDRESS");
  command.essentials({"--to"});
  add_store_options(command, arguments->upload.http);
  command.callback([arguments, command, &exit_code] {
    if (command.parsed_subcommands().empty()) exit_code = run_pack(*arguments);
  });
  add_parts_commands(command, exit_code);
}

}  // namespace pointreel
