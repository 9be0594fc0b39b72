#pragma once

#include <cstdint>
#include <functional>
#include <stop_token>
#include <string>

#include "pointreel/bytes.h"
#include "pointreel/error.h"

namespace pointreel {

/// The name under which the machine's microphone is a source of sound.
inline constexpr const char* kMicrophone = "microphone";

struct SoundSource {
  std::string name;            ///< a file that ffmpeg reads, or kMicrophone
  bool loop = false;           ///< play a file again and again
  std::uint64_t begin_us = 0;  ///< when a file begins, as Unix time
};

/// Takes a packet of Opus, as of LiveSound.
using OnSoundPacket =
    std::function<void(ByteView packet, std::uint16_t samples, std::uint64_t capture_us)>;

/// Whether there is ffmpeg, and the file, and whether that is whole. Errors: `not_found`; those of
/// find_sound_end.
Result<void> check_sound(const std::string& name);

/// Encodes sound with ffmpeg, in packets of 20 ms, and hands each over when it has been heard: what
/// a file has, at its place behind `begin_us`; what the microphone (ALSA's default device) hears,
/// when it comes. Returns at the end of the file, or when it is to stop: what ffmpeg found wrong
/// although all the sound came, or an empty text. Errors begin with the name; a file of which less
/// came than it has is one.
Result<std::string> send_sound(const SoundSource& source, const OnSoundPacket& on_packet,
                               const std::stop_token& stop);

}  // namespace pointreel
