#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pointreel/error.h"

/// Files of sound as ffmpeg reads them. Its exit status does not tell whether it has read all: it
/// goes on behind damage, and ends well where a file is cut off. So the length of the result is
/// compared with that of the file.
namespace pointreel {

/// ffmpeg's arguments that open a file as its next input. No playlist (HLS, DASH, concat), which
/// would make it read other files: only formats that hold their sound themselves.
std::vector<std::string> sound_input(const std::filesystem::path& file);

/// Where the first track of sound ends, in microseconds from the beginning of the file.
struct SoundEnd {
  std::uint64_t end_us = 0;
  /// What is lost at the end for the sake of whole packets.
  std::uint64_t slack_us = 0;
  /// The length of the track, unless the file does not tell and was not read to its end.
  std::optional<std::uint64_t> whole_us = {};

  /// An error if `got_us` are fewer than `wanted_us`, or than the file has. `why`: what ffmpeg
  /// said.
  Result<void> check(std::uint64_t got_us, std::uint64_t wanted_us, const std::string& why) const;
};

/// Reads the packets of a file, decoding nothing, up to `most_us` if it is given. Errors do not
/// contain the path: `not_found` if ffprobe is not installed, `io`, and `invalid` if the file has
/// no sound, is a playlist, or is cut off: it ends before the end that it states itself.
Result<SoundEnd> find_sound_end(const std::filesystem::path& file,
                                std::optional<std::uint64_t> most_us = {});

/// What ffmpeg means, which could not read the file: its first line, or words of our own.
Error unreadable_sound(const std::string& why);

/// For errors where ffmpeg or ffprobe is missing.
inline constexpr const char* kSoundNeedsFfmpeg =
    "ffmpeg is not installed, but sound needs it: install it (apt-get install ffmpeg)";

}  // namespace pointreel
