#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "codec/package/encoding_options.h"
#include "common/command_line/command.h"
#include "pointreel/codec.h"
#include "pointreel/draco.h"
#include "pointreel/error.h"

namespace pointreel {

/// Which normals octrees get: those of the source, estimates where it has none and that pays, or
/// in any case; or none.
enum class SentNormals { automatic, source, estimate, none };

/// The options that the command lines of pack and publish share. Names, ranges and descriptions
/// stand here only; the defaults are the values that the members have before `add_to`.
struct SequenceArguments {
  EncodingOptions sequence;  ///< all but `sequence.encode.codec`
  Codec codec = Codec::octree;
  bool with_video = false;  ///< whether --codec may be video
  SentNormals normals = SentNormals::source;
  OctreeOptions octree;
  DracoOptions draco;

  /// Adds the options to a command, which this object must outlive. The texts complete the
  /// descriptions of --name, --frame-time and --clean-frames.
  void add_to(cli::Command command, const char* default_name, const char* about_frame_time,
              const char* about_clean_frames);

  /// Declares an option of the command that makes sense only with one codec, or only with
  /// Entropy::context.
  cli::Option only_with(Codec of, cli::Option option);
  /// The same for options of octrees that video has, too.
  cli::Option not_with_draco(cli::Option option);
  cli::Option only_with_context(cli::Option option);

  /// Whether the axis that points up is to be taken from files whose format tells it: it was not
  /// given, and they are not turned.
  bool up_of_files() const;
  /// Whether the times of frames are to be taken from recordings: --fps was not given.
  bool times_of_files() const { return fps_.count() == 0; }

  /// Whether --codec was given, or an option or a quality that only one codec has.
  bool asks_for_codec() const;

  /// What was given; an error if some of it does not go together.
  Result<EncodingOptions> options() const;

 private:
  std::uint64_t frame_memory_ = kFrameMemory >> 20;  ///< MiB
  cli::Option up_, fps_, codec_, clean_frames_, normal_quality_, scalar_step_;
  void add_octree_options(cli::Command command);
  void add_scalar_options(cli::Command command);
  void add_draco_options(cli::Command command);

  std::vector<std::pair<Codec, cli::Option>> of_codec_;
  std::vector<cli::Option> of_context_, of_layers_;
};

/// An option with a value for each of some words.
template <class T>
cli::Option add_choice(cli::Command command, const char* flag, T& value,
                       const std::vector<std::pair<std::string, T>>& choices,
                       const char* description) {
  std::vector<std::string> words;
  std::string chosen;
  for (const auto& [word, meaning] : choices) {
    words.push_back(word);
    if (meaning == value) chosen = word;
  }
  const auto set = [&value, choices](const std::string& given) {
    for (const auto& [word, meaning] : choices) {
      if (word == given) value = meaning;
    }
  };
  return command.add_option_function<std::string>(flag, set, description)
      .check(cli::one_of(words))
      .default_str(chosen);
}

}  // namespace pointreel
