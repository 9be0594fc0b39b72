#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "codec/segments/pack_options.h"
#include "pointreel/error.h"
#include "pointreel/package.h"
#include "server/pack/packer.h"

/// Packing in parts, by any number of processes on any number of machines that share a file system.
///
///   make_plan   decides what all parts must agree on, and writes it to a folder beside the output
///   pack_part   packs some of the segments into that folder (pack_part.h)
///   join_parts  makes the package of them (join_parts.h)
///
/// The package has the same bytes as if one process had packed it.
namespace pointreel {

/// A source frame, as it was when the plan was made.
struct PlannedFrame {
  std::filesystem::path path;                 ///< absolute
  std::uint64_t bytes = 0;                    ///< of the file, or of a capture of depth
  std::optional<std::uint32_t> index;         ///< in the recording; none if the file has one frame
  std::optional<std::uint64_t> time_us = {};  ///< CloudFrame::time_us
};

/// The size of a file, or of all pictures of a capture of depth. Errors begin with the path.
Result<std::uint64_t> bytes_of_source(const std::filesystem::path& path);

/// What `plan.json` says.
struct PackPlan {
  /// The options of `pack` as PackArguments::command_line gives them, and what was guessed of how
  /// the frames are read. Each part parses them again, so that an option that is added to `pack`
  /// holds for parts as well.
  std::vector<std::string> arguments;
  std::string name;                   ///< of the reel
  std::optional<Up> up;               ///< the axis, where the first frame tells it
  std::uint32_t segment_frames = 30;  ///< of each segment but the last
  bool force = false;                 ///< join may replace a package
  std::optional<bool> noisy;          ///< CleanOptions::noisy
  std::vector<PlannedFrame> frames;
  std::optional<std::filesystem::path> audio;  ///< absolute; join gives the package its sound
  std::optional<PackageFile> tables;           ///< in the folder of the plan

  std::uint32_t segments() const {
    return static_cast<std::uint32_t>((frames.size() + segment_frames - 1) / segment_frames);
  }
  std::uint32_t first_frame(std::uint32_t segment) const { return segment * segment_frames; }
  /// The frames of a segment.
  std::span<const PlannedFrame> frames_of(std::uint32_t segment) const;
};

/// The folder of a plan and its parts: OUTPUT.parts.
std::filesystem::path parts_folder(const std::filesystem::path& output);

/// The manifest of one segment in that folder. It is there if and only if the segment is whole.
std::filesystem::path segment_manifest(const std::filesystem::path& folder,
                                       std::uint32_t first_frame);

struct MadePlan {
  std::uint32_t frames = 0, segments = 0;
  std::optional<LearntTables> learnt;  ///< with PackOptions::train
  std::vector<std::string> warnings;   ///< CloudSequence::warnings
  std::vector<std::string> guesses;    ///< CloudSequence::guesses
  std::optional<VideoTrial> trial;     ///< PackSummary::trial
};

/// Lists the input frames, learns context tables if that is asked for, and writes the plan.
/// `arguments` are PackPlan::arguments and must have been parsed into `options`. A plan that is
/// already there is replaced, with its parts, if options.force is set. Errors: `argument` for
/// PackOptions::frame_time_ms, which would make bytes depend on the machine, and for an output that
/// exists and may not be replaced.
Result<MadePlan> make_plan(const PackOptions& options, std::vector<std::string> arguments,
                           const std::stop_token& stop = {});

/// Reads the plan for this output. The error begins with the path; its code is `not_found` if there
/// is no plan.
///
/// Trust: the text may be damaged. Its memory is bounded by a constant times its size.
Result<PackPlan> read_plan(const std::filesystem::path& output);

}  // namespace pointreel
