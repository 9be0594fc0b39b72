#include "codec/live/live_sound.h"

#include "codec/core/reel_rules.h"
#include "codec/live/header_checksum.h"
#include "common/base/byte_io.h"
#include "common/base/concat.h"
#include "common/base/try.h"
#include "pointreel/package.h"

namespace pointreel {
namespace {

constexpr std::uint32_t kSoundMagic = 0x31535250;  // "PRS1"

}  // namespace

bool is_live_sound(ByteView message) {
  return ByteReader(message).get<std::uint32_t>() == kSoundMagic;
}

Bytes write_live_sound(const LiveSound& sound) {
  Bytes message;
  message.reserve(kSoundHeaderSize + sound.packet.size());
  ByteWriter out(message);
  out.put(kSoundMagic);
  out.put(sound.number);
  out.put(sound.capture_us);
  out.put(sound.samples);
  out.put(std::uint16_t{0});
  out.put(header_checksum(message));
  message.insert(message.end(), sound.packet.begin(), sound.packet.end());
  return message;
}

Result<LiveSound> parse_live_sound(ByteView message) {
  ByteReader in(message);
  LiveSound sound;
  const auto magic = in.get<std::uint32_t>();
  sound.number = in.get<std::uint32_t>();
  sound.capture_us = in.get<std::uint64_t>();
  sound.samples = in.get<std::uint16_t>();
  const auto reserved = in.get<std::uint16_t>();
  const auto checksum = in.get<std::uint32_t>();
  if (!in.ok()) return fail("sound: is shorter than its header");
  if (magic != kSoundMagic) return fail("sound: does not begin with PRS1");
  if (checksum != header_checksum(message.first(kSoundHeaderSize - sizeof(checksum))))
    return fail("sound: its header is damaged");
  if (reserved != 0) return fail("sound: reserved bytes are not 0");
  if (sound.capture_us > kMaxCaptureTime) return fail("sound: its capture time is out of range");
  if (sound.samples == 0 || sound.samples > kMaxSoundSamples)
    return fail(concat("sound: has ", sound.samples, " samples"));
  sound.packet = in.rest();
  if (sound.packet.empty()) return fail("sound: has no packet");
  if (sound.packet.size() > kMaxSoundPacket)
    return fail(ErrorCode::limit, concat("sound: has more than ", kMaxSoundPacket, " bytes"));
  return sound;
}

void append_live_sound(std::string& file, ByteView message) {
  Bytes size;
  ByteWriter(size).put(static_cast<std::uint16_t>(message.size()));
  file.append(size.begin(), size.end());
  file.append(message.begin(), message.end());
}

Result<std::vector<LiveSound>> parse_live_sound_file(ByteView file) {
  std::vector<LiveSound> sounds;
  while (!file.empty()) {
    ByteReader in(file);
    const auto size = in.get<std::uint16_t>();
    const ByteView rest = in.rest();
    if (!in.ok() || size > rest.size()) return fail("sound: its file ends within a message");
    sounds.push_back(TRY(parse_live_sound(rest.first(size))));
    file = rest.subspan(size);
  }
  return sounds;
}

}  // namespace pointreel
