#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "pointreel/bytes.h"
#include "pointreel/error.h"

/// Sound in live streams: PROTOCOL.md, "Live".
///
/// Trust: as live.h. The packet is not decoded here.
namespace pointreel {

/// The longest packet, in bytes. Opus needs at most 1,276 for 20 ms.
inline constexpr std::size_t kMaxSoundPacket = 4096;
/// The size of the header of a message.
inline constexpr std::size_t kSoundHeaderSize = 24;
/// The longest packet, in samples at 48,000 Hz.
inline constexpr std::uint16_t kMaxSoundSamples = 5760;

/// One packet of Opus, of one or two channels.
struct LiveSound {
  std::uint32_t number = 0;      ///< counts the packets of the session; increases
  std::uint64_t capture_us = 0;  ///< of its first sample; as of a LiveLayer
  std::uint16_t samples = 0;     ///< of each channel at 48,000 Hz, 1 to kMaxSoundSamples
  ByteView packet;               ///< not owned
};

/// Whether a binary message is sound, by how it begins. Otherwise it is a layer.
bool is_live_sound(ByteView message);
Bytes write_live_sound(const LiveSound& sound);
/// `packet` of the result points into the message. Errors: `limit` for more than kMaxSoundPacket
/// bytes, otherwise `invalid`.
Result<LiveSound> parse_live_sound(ByteView message);

/// Over HTTP, packets come in a file for each segment: PROTOCOL.md, "Live over HTTP". Adds a
/// message, of at most 65,535 bytes, to such a file.
void append_live_sound(std::string& file, ByteView message);
/// Packets point into the file. Errors: as parse_live_sound.
Result<std::vector<LiveSound>> parse_live_sound_file(ByteView file);

}  // namespace pointreel
