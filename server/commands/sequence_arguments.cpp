#include "server/commands/sequence_arguments.h"

#include <algorithm>
#include <ranges>
#include <string>

#include <fmt/format.h>

#include "codec/cloud_options/cloud_options.h"
#include "codec/core/json_fields.h"
#include "codec/octree/context_coder.h"
#include "common/command_line/command.h"
#include "pointreel/octree.h"

namespace pointreel {
namespace {

/// What --clean says, which has been checked.
std::optional<CleanOptions> cleaning_from(const std::string& text) {
  if (text == "off") return std::nullopt;
  if (text == "auto") return CleanOptions{};
  return CleanOptions{*cli::number_of(text)};
}

}  // namespace

cli::Option SequenceArguments::only_with(Codec of, cli::Option option) {
  of_codec_.emplace_back(of, option);
  return option.group(of == Codec::octree ? "Octree" : "Draco");
}

cli::Option SequenceArguments::not_with_draco(cli::Option option) {
  of_layers_.push_back(option);
  return option.group("Octree");
}

cli::Option SequenceArguments::only_with_context(cli::Option option) {
  of_context_.push_back(option);
  return only_with(Codec::octree, option);
}

void SequenceArguments::add_to(cli::Command command, const char* default_name,
                               const char* about_frame_time, const char* about_clean_frames) {
  fps_ = command
             .add_option("--fps", sequence.fps,
                         "frames per second; without it, those of recordings are shown at the "
                         "times at which they were recorded")
             .check(cli::number_option("a number from 0.000001 to 1000000", is_frame_rate))
             .capture_default_str();
  up_ = add_choice<Up>(
      command, "--up", sequence.up,
      {{"x", 'x'},
       {"-x", {'x', true}},
       {"y", 'y'},
       {"-y", {'y', true}},
       {"z", 'z'},
       {"-z", {'z', true}}},
      "the axis that points up, unless the format of the files tells it, as LAS, KITTI, nuScenes "
      "and MCAP do with z; -y turns upright a scene whose y axis points down");
  add_placement_options(command, sequence.placement);
  command.add_option("--name", sequence.name,
                     fmt::format("a display name (default: that of the {})", default_name));
  command
      .add_option("--threads", sequence.threads, "threads that encode; 0: one for each processor")
      .check(cli::range(0, 1024))
      .capture_default_str();
  add_frame_memory_option(command, frame_memory_);
  command
      .add_option(
          "--frame-time", sequence.frame_time_ms,
          fmt::format("milliseconds that encoding a frame may take; the depth is lowered to "
                      "achieve this ({})",
                      about_frame_time))
      .check(cli::positive_number())
      .type_name("MS");
  std::vector<std::pair<std::string, Codec>> codecs{{name(Codec::octree), Codec::octree},
                                                    {name(Codec::draco), Codec::draco}};
  if (with_video) codecs.emplace_back(name(Codec::video), Codec::video);
  codec_ = add_choice<Codec>(
      command, "--codec", codec, codecs,
      with_video ? "octrees, in layers that refine each other; Draco; or video: "
                   "pictures of depth and colours, which take a fraction of the bits "
                   "for dense, clean surfaces that move"
                 : "octrees, in layers that refine each other, or Draco");
  if (with_video) codec_.default_str("octree or video, by a trial");
  command
      .add_option_function<std::string>(
          "--clean", [this](const std::string& text) { sequence.clean = cleaning_from(text); },
          fmt::format(
              "move the points of noisy scans onto the surface that they are samples of, and "
              "remove "
              "points without a surface: off, auto (where it helps, by as much as the noise asks "
              "for; not with --voxel), or the radius within which the surface is smoothed, in the "
              "source's units (default: {})",
              sequence.clean ? "auto for frames with normals, which tell the two sides of thin "
                               "parts apart; off for others"
                             : "off"))
      .check({[](const std::string& text) {
        const bool good =
            text == "off" || text == "auto" || cli::positive_number().fault(text).empty();
        return good ? std::string() : text + " is not off, auto or a radius above 0";
      }})
      .type_name("HOW");
  clean_frames_ =
      command
          .add_option(
              "--clean-frames", sequence.clean_frames,
              fmt::format("so many frames {} each one help to clean it: less noise and flicker, "
                          "sharper features, and about three times the work; 0: each frame by "
                          "itself",
                          about_clean_frames))
          .check(cli::range(0, static_cast<int>(kMostCleanFrames)))
          .type_name("N")
          .capture_default_str();
  std::vector<std::pair<std::string, SentNormals>> sent{{"send", SentNormals::source},
                                                        {"derive", SentNormals::none}};
  if (with_video) {
    normals = SentNormals::automatic;
    sent.insert(sent.begin(), {"auto", SentNormals::automatic});
    sent.insert(sent.end() - 1, {"estimate", SentNormals::estimate});
  }
  const cli::Option choice = add_choice<SentNormals>(
      command, "--normals", normals, sent,
      with_video ? "send the normals of the source; estimate those of frames without, and send "
                   "them, too; or let players derive them from the points. auto: send, and "
                   "estimate for octrees of frames with colours that are so dense that players "
                   "would be slow"
                 : "send the normals of the source, or let players derive them from the points");
  command
      .add_flag_callback(
          "--no-normals", [this] { normals = SentNormals::none; },
          "leave normals out, the same as --normals derive")
      .excludes(choice);
  command.add_flag_callback(
      "--no-colors", [this] { sequence.encode.colors = false; }, "leave colours out");
  add_octree_options(command);
  add_scalar_options(command);
  add_draco_options(command);
}

void SequenceArguments::add_octree_options(cli::Command command) {
  const cli::Option delta = only_with(
      Codec::octree,
      command
          .add_option_function<double>(
              "--delta",
              [this](double share) {
                octree.depth = DepthRule::by_delta(share);
                sequence.cells_fit_cleaned = false;
              },
              "divide the octree until at most this share of the distinct points has merged into "
              "others; without it, frames that were cleaned have cells that fit their points")
          .check(cli::number_option("a number of at least 0", [](double v) { return v >= 0.0; }))
          .default_str(fmt::format("{}", octree.depth.delta)));
  const cli::Option depth =
      only_with(Codec::octree,
                command
                    .add_option_function<int>(
                        "--depth", [this](int levels) { octree.depth = DepthRule::fixed(levels); },
                        "instead of --delta: a fixed depth; voxels of the source are not "
                        "divided")
                    .check(cli::range(0, kMaxDepth)));
  const cli::Option voxel = only_with(
      Codec::octree,
      command
          .add_option("--voxel", sequence.voxel,
                      "instead of --delta: voxels of this size in the source's units, centred on "
                      "its multiples, or on the voxels of the source that they merge")
          .check(cli::positive_number()));
  const cli::Option spacing =
      only_with(Codec::octree, command
                                   .add_option_function<double>(
                                       "--spacing",
                                       [this](double size) {
                                         sequence.voxel = size;
                                         sequence.resample = true;
                                       },
                                       "instead of --delta: after cleaning, one sample of the "
                                       "surface in each cell of this size in the source's units")
                                   .check(cli::positive_number())
                                   .type_name("SIZE"));
  delta.excludes(depth).excludes(voxel).excludes(spacing);
  depth.excludes(voxel).excludes(spacing);
  voxel.excludes(spacing);
  only_with(Codec::octree, add_choice<Entropy>(command, "--entropy", octree.entropy,
                                               {{name(Entropy::none), Entropy::none},
                                                {name(Entropy::zstd), Entropy::zstd},
                                                {name(Entropy::context), Entropy::context}},
                                               "how the octree is compressed: context gives the "
                                               "fewest bytes, none is the fastest"));
  only_with_context(command
                        .add_option("--slabs", octree.slabs,
                                    "code a frame in this many parts, in parallel in encoder and "
                                    "player, each at about 1 % of its bytes; 0: one part below "
                                    "2^20 voxels, then one for each 2^19")
                        .check(cli::range(0, kMostSlabs))
                        .capture_default_str());
  not_with_draco(
      command
          .add_option("--quality", octree.color_quality,
                      with_video
                          ? "quality of colours, with video of depth, too; with octrees every "
                            "+14 halves the error and 100 is lossless"
                          : "quality of colours; every +14 halves the error, 100 is lossless")
          .check(cli::range(1, kLosslessColorQuality))
          .capture_default_str());
  normal_quality_ = only_with(
      Codec::octree,
      command
          .add_option_function<int>(
              "--normal-quality",
              [this](int quality) {
                octree.normal_quality = quality;
                octree.normals_follow_noise = false;
              },
              fmt::format("quality of normals on the same scale; 100 is within half a degree "
                          "(default: {}, or less for normals that are noisier than that)",
                          octree.normal_quality))
          .check(cli::range(1, kBestNormalQuality)));
}

void SequenceArguments::add_scalar_options(cli::Command command) {
  only_with(Codec::octree, command.add_flag_callback(
                               "--no-scalars", [this] { octree.scalars = false; },
                               "leave scalar fields, such as intensities, out"));
  const auto parsed = [](const std::string& text) -> std::optional<ScalarStep> {
    const std::size_t at = text.rfind('=');
    if (at == std::string::npos || !is_scalar_name(text.substr(0, at))) return std::nullopt;
    const std::string number = text.substr(at + 1);
    if (!cli::positive_number().fault(number).empty()) return std::nullopt;
    return ScalarStep{text.substr(0, at), *cli::number_of(number)};
  };
  scalar_step_ = only_with(
      Codec::octree,
      command
          .add_option_function<std::vector<std::string>>(
              "--scalar-step",
              [this, parsed](const std::vector<std::string>& all) {
                for (const std::string& text : all) octree.scalar_steps.push_back(*parsed(text));
              },
              "keep this scalar field to within half of this step (default: whole numbers "
              "that span up to 255 exactly, others in steps of 1/255 of their range)")
          .check({[parsed](const std::string& text) {
            return parsed(text) ? std::string() : text + " is not NAME=STEP with a step above 0";
          }})
          .type_name("NAME=STEP"));
}

void SequenceArguments::add_draco_options(cli::Command command) {
  const auto add = [&](const char* flag, int& value, const char* what, int least, int most) {
    only_with(
        Codec::draco,
        command.add_option(flag, value, what).check(cli::range(least, most)).capture_default_str());
  };
  add("--qp", draco.position_bits, "bits of each coordinate of a position", 1, kMaxDepth);
  add("--qn", draco.normal_bits, "bits of a normal", kMinNormalBits, kMaxNormalBits);
  add("--cl", draco.compression_level, "compression level: 0 is the fastest, 10 the smallest", 0,
      kMaxCompressionLevel);
  only_with(Codec::draco,
            add_choice<DracoMethod>(command, "--method", draco.method,
                                    {{"auto", DracoMethod::automatic},
                                     {"kd-tree", DracoMethod::kd_tree},
                                     {"sequential", DracoMethod::sequential}},
                                    "how points are ordered; auto is sequential at --cl 0, "
                                    "otherwise kd-tree"));
}

bool SequenceArguments::up_of_files() const {
  return up_.count() == 0 && sequence.placement.rotation == glm::dmat3(1.0);
}

bool SequenceArguments::asks_for_codec() const {
  const auto given = [](const cli::Option option) { return option.count() > 0; };
  return given(codec_) || octree.color_quality == kLosslessColorQuality ||
         normals == SentNormals::estimate ||
         std::ranges::any_of(of_codec_ | std::views::values, given) ||
         std::ranges::any_of(of_context_, given);
}

Result<EncodingOptions> SequenceArguments::options() const {
  if (!is_title(sequence.name)) {
    return fail(ErrorCode::argument,
                "--name: is too long, or has a character that must not be shown: a control "
                "character, or one that turns the direction of writing");
  }
  for (const auto& [of, option] : of_codec_) {
    if (option.count() == 0 || of == codec) continue;
    return fail(ErrorCode::argument, fmt::format("{} needs --codec {}", option.name(), name(of)));
  }
  for (const cli::Option option : of_layers_) {
    if (option.count() == 0 || codec != Codec::draco) continue;
    return fail(ErrorCode::argument,
                fmt::format("{} does not go with --codec draco", option.name()));
  }
  for (const cli::Option option : of_context_) {
    if (option.count() == 0 || octree.entropy == Entropy::context) continue;
    return fail(ErrorCode::argument,
                fmt::format("{} needs --entropy {}", option.name(), name(Entropy::context)));
  }
  const auto in_vain = [](const cli::Option option, const char* with) {
    return fail(ErrorCode::argument, fmt::format("{} does nothing with {}", option.name(), with));
  };
  if (clean_frames_.count() > 0 && !sequence.clean) return in_vain(clean_frames_, "--clean off");
  if (normal_quality_.count() > 0 && normals == SentNormals::none)
    return in_vain(normal_quality_, "--normals derive");
  if (scalar_step_.count() > 0 && !octree.scalars) return in_vain(scalar_step_, "--no-scalars");
  if (normals == SentNormals::estimate && codec != Codec::octree)
    return fail(ErrorCode::argument, "--normals estimate needs --codec octree");
  EncodingOptions options = sequence;
  options.encode.normals = normals != SentNormals::none;
  if (normals == SentNormals::automatic)
    options.missing_normals = MissingNormals::estimated_if_it_pays;
  if (normals == SentNormals::estimate) options.missing_normals = MissingNormals::estimated;
  options.max_memory = frame_memory_ << 20;
  if (codec == Codec::draco) {
    options.encode.codec = draco;
  } else {
    options.encode.codec = octree;
  }
  return options;
}

}  // namespace pointreel
