#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <stop_token>
#include <string>

#include "pointreel/error.h"
#include "pointreel/package.h"

namespace pointreel {

/// A part of the sound of a package, and its place in the sound of another one. In samples.
struct SoundPiece {
  std::filesystem::path file;
  std::string shown;        ///< the file, for people
  std::uint64_t bytes = 0;  ///< of the file
  std::uint64_t first = 0;  ///< with which it begins, in the file
  std::uint64_t begin = 0;  ///< where that one is in the new sound
  std::uint64_t end = 0;    ///< where the piece ends there; later than it begins
};

/// Makes one file of sound of pieces, which are in order and do not overlap, by copying the packets
/// of Opus. Where there is no sound, there is silence. Nothing if no piece has sound in its part.
///
/// The beginning and the end are exact to the sample. Since packets are whole, sound that begins
/// later may do so early or late by half a packet, which is 10 ms as a rule, and for as long is
/// there silence before it.
///
/// Errors: `io`; `invalid` for sound that is damaged; `argument` for sound that does not go
/// together; `limit` for more than kMaxAudioBytes; `cancelled`.
///
/// Trust: the files may be hostile; OpusReader reads them. Memory is bounded, and so are the bytes
/// that are written.
Result<std::optional<AudioFile>> splice_sound(std::span<const SoundPiece> pieces,
                                              const std::filesystem::path& folder,
                                              const std::stop_token& stop = {});

}  // namespace pointreel
