#include "server/commands/pack_arguments.h"

#include <utility>

#include <fmt/format.h>

#include "codec/cloud_options/cloud_options.h"
#include "codec/rate/bitrate.h"
#include "codec/video/video_group.h"
#include "common/base/try.h"

namespace pointreel {
void PackArguments::add_to(cli::Command command) {
  command_ = command;
  input_ = command
               .add_option(
                   "-i,--input", options_.inputs,
                   "folders and files of points (PLY, Draco, PCD, LAS, text, OBJ, glTF, numpy, "
                   "KITTI, nuScenes, MCAP), and of depth (a folder with depth/*.png, or .mkv, with "
                   "intrinsics in JSON); the files of a folder are taken in natural order, so "
                   "that frame2 comes before frame10")
               .type_name("PATH")
               .expected(1, -1);
  output_ = command
                .add_option("-o,--output", options_.output,
                            "the folder of the package; not needed with --to")
                .type_name("REEL");
  paths_ = command
               .add_option("PATHS", given_paths_,
                           "the input, and then the package folder unless --output names it")
               .type_name("");
  add_topic_option(command, options_.topic);
  add_reading_options(command, options_.reading);
  add_choice<bool>(command, "--cube", options_.cube_per_frame, {{"group", false}, {"frame", true}},
                   "one cube for all frames of a segment, so that the voxels of resting surfaces "
                   "do not move, or one for each frame");
  command
      .add_option_function<std::string>(
          "--bitrate", [this](const std::string& text) { options_.bitrate = *parse_bitrate(text); },
          "bits per second, such as 20M or 800k, that no segment exceeds on average; depth and "
          "qualities are lowered to achieve this; segments of video are encoded up to five times")
      .check(cli::parsed_by(parse_bitrate))
      .type_name("RATE");
  group_ = command
               .add_option(
                   "--group", video_.group_frames,
                   "frames of a group of video: the more, the smaller, and the longer it takes to "
                   "seek into its middle")
               .check(cli::range(1, kMostGroupFrames))
               .capture_default_str()
               .group("Video");
  effort_ = command
                .add_option("--effort", video_.effort,
                            "time against size of video: 0 is the fastest, 9 the smallest")
                .check(cli::range(0, kMostVideoEffort))
                .capture_default_str()
                .group("Video");
  segment_ =
      command
          .add_option("--segment", options_.segment_frames,
                      fmt::format("frames in a segment; they share a cube and a file (default: {}; "
                                  "of video, {})",
                                  options_.segment_frames, video_.segment_frames))
          .check(cli::range(1, kMostSegmentFrames));
  audio_ =
      command
          .add_option("--audio", options_.audio,
                      "sound, from any file that ffmpeg reads except playlists; what is longer "
                      "than the frames is cut off")
          .type_name("FILE");
  sequence_.with_video = true;
  sequence_.sequence.clean = CleanOptions{.without_normals = false};
  sequence_.sequence.clean_frames = 2;
  sequence_.add_to(command, "folder", "the package then depends on the speed of this machine",
                   "on either side of");
  command.add_flag("--keep-gaps", options_.keep_gaps,
                   "where frames are missing by the numbers in the names of files, show the frame "
                   "before for their time, so that sound does not run ahead");
  command.add_flag("--best-effort", options_.best_effort,
                   "warn instead of failing: leave out stray points and damaged parts of "
                   "recordings, show a nearby frame instead of one that cannot be read, and "
                   "pack what lies too far apart for the cube that it shares, or exceeds the bit "
                   "rate at its coarsest");
  force_ = command.add_flag("--force", options_.force, "replace a package that is already there");
  sequence_.only_with_context(command.add_flag(
      "--train", options_.train,
      "learn the context tables from the frames, and keep them in the package if that makes it "
      "smaller"));
  sequence_.only_with(
      Codec::draco,
      command.add_flag("--measure-parts", options_.measure_parts,
                       "also report how the bytes divide into geometry, colours and normals, "
                       "which takes two more encodes per frame"));
  command.essentials({"--input", "--output", "--force", "--codec", "--quality", "--bitrate",
                      "--clean", "--fps", "--up", "--scale", "--audio", "--best-effort",
                      "--threads"});
}

Result<PackOptions> PackArguments::options() const {
  PackOptions options = options_;
  static_cast<EncodingOptions&>(options) = TRY(sequence_.options());
  VideoPackOptions video = video_;
  video.quality = sequence_.octree.color_quality;
  if (segment_.count() > 0) video.segment_frames = options.segment_frames;
  if (sequence_.codec == Codec::video) {
    if (options.cube_per_frame)
      return fail(ErrorCode::argument,
                  "--cube frame does not go with --codec video, whose frames share a cube");
    options.pack_as_video(video);
  } else if (group_.count() + effort_.count() > 0) {
    return fail(
        ErrorCode::argument,
        fmt::format("{} needs --codec video", group_.count() > 0 ? group_.name() : effort_.name()));
  } else if (!sequence_.asks_for_codec() && !options.cube_per_frame && !options.frame_time_ms) {
    options.video_if_it_pays = video;
  }
  options.up_of_files = sequence_.up_of_files();
  options.times_of_files = sequence_.times_of_files() || options.keep_gaps;
  return options;
}

Result<PackOptions> PackArguments::options_with_paths(bool needs_output) const {
  PackOptions options = TRY(this->options());
  std::vector<std::filesystem::path> paths = given_paths_;
  if (options.output.empty() && needs_output && !paths.empty()) {
    options.output = std::move(paths.back());
    paths.pop_back();
  }
  if (options.inputs.empty())
    options.inputs = std::move(paths);
  else if (!paths.empty())
    return fail(ErrorCode::argument,
                paths.front().string() + ": is not needed beside --input and --output");
  if (options.inputs.empty())
    return fail(
        ErrorCode::argument,
        needs_output && !options.output.empty() && output_.count() == 0
            ? fmt::format("name the folder of the package, too, as in pack FOLDER REEL: only "
                          "{} was given",
                          options.output.string())
            : "name a folder or file of points: pack FOLDER REEL");
  if (options.output.string().find("://") != std::string::npos)
    return fail(ErrorCode::argument,
                options.output.string() + ": is not a folder; --to uploads to such an address");
  if (needs_output && options.output.empty())
    return fail(ErrorCode::argument,
                options.inputs.size() < 2
                    ? "name the folder of the package: pack FOLDER REEL"
                    : fmt::format("--input takes all words that follow, {} too; name the folder of "
                                  "the package with --output",
                                  options.inputs.back().string()));
  return options;
}

std::vector<std::string> PackArguments::command_line() const {
  std::vector<std::string> line;
  for (const cli::Option option : command_.options()) {
    const bool of_the_whole = option == paths_ || option == input_ || option == output_ ||
                              option == force_ || option == audio_;
    if (option.count() == 0 || of_the_whole) continue;
    if (option.is_flag()) {
      line.push_back(option.name());
      continue;
    }
    // "--name=value", since a value may begin with a minus sign. Empty ones stand for the default,
    // and could not be read back.
    for (const std::string& value : option.values())
      if (!value.empty()) line.push_back(option.name() + "=" + value);
  }
  return line;
}

Result<PackOptions> parse_pack_command_line(const std::vector<std::string>& arguments) {
  cli::Program app;
  PackArguments parsed;
  parsed.add_to(app);
  TRY(app.parse(arguments));
  return parsed.options();
}

}  // namespace pointreel
