#include "server/publish/sound_input.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <memory>
#include <system_error>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <fmt/format.h>
#include <ogg/ogg.h>
#include <opus/opus.h>
#include <unistd.h>

#include "codec/audio/sound_file.h"
#include "codec/live/live_sound.h"
#include "common/base/try.h"
#include "common/file_system/descriptor.h"
#include "common/process/ffmpeg.h"
#include "server/publish/frame_input.h"

namespace pointreel {
namespace {

constexpr int kRate = 48'000;
/// By how many samples libopus delays what it encodes. Viewers decode all there is, so that many
/// are left out at the beginning of a file.
constexpr int kEncoderDelay = 312;
/// A microphone's time that is this far from the machine's is set anew: its clock has another pace.
constexpr std::int64_t kMostOff = 100'000;

std::vector<std::string> arguments(const SoundSource& source) {
  std::vector<std::string> all;
  std::string filter = fmt::format("aresample={}", kRate);
  const auto add = [&all](std::initializer_list<std::string> some) { all.insert(all.end(), some); };
  if (source.name == kMicrophone) {
    add({"-f", "alsa", "-i", "default"});
  } else {
    if (source.loop) add({"-stream_loop", "-1"});
    const std::vector<std::string> input = sound_input(source.name);
    all.insert(all.end(), input.begin(), input.end());
    add({"-map", "0:a:0"});
    filter += fmt::format(",atrim=start_sample={},asetpts=N/SR/TB", kEncoderDelay);
  }
  add({"-af", filter, "-ac", "2", "-c:a", "libopus", "-b:a", "96k", "-frame_duration", "20", "-f",
       "ogg", "-page_duration", "20000", "-flush_packets", "1", "pipe:1"});
  return all;
}

/// The packets of Opus in Ogg, without the two of the header.
class OggPackets {
 public:
  OggPackets() { ogg_sync_init(&sync_); }
  ~OggPackets() {
    if (begun_) ogg_stream_clear(&stream_);
    ogg_sync_clear(&sync_);
  }
  OggPackets(const OggPackets&) = delete;
  OggPackets& operator=(const OggPackets&) = delete;

  void add(ByteView bytes) {
    char* const room = ogg_sync_buffer(&sync_, static_cast<long>(bytes.size()));
    if (room == nullptr) return;
    std::memcpy(room, bytes.data(), bytes.size());
    ogg_sync_wrote(&sync_, static_cast<long>(bytes.size()));
  }

  template <class Take>
  void for_each(const Take& take) {
    ogg_page page;
    while (ogg_sync_pageout(&sync_, &page) == 1) {
      if (!std::exchange(begun_, true)) ogg_stream_init(&stream_, ogg_page_serialno(&page));
      ogg_stream_pagein(&stream_, &page);
      ogg_packet packet;
      while (ogg_stream_packetout(&stream_, &packet) == 1)
        if (++packets_ > 2) take(ByteView(packet.packet, static_cast<std::size_t>(packet.bytes)));
    }
  }

 private:
  ogg_sync_state sync_{};
  ogg_stream_state stream_{};
  bool begun_ = false;
  std::uint64_t packets_ = 0;
};

/// The times of packets, and the waiting for them.
class SoundTimes {
 public:
  explicit SoundTimes(const SoundSource& source)
      : live_(source.name == kMicrophone), begin_us_(source.begin_us) {}

  /// The time of the next packet's first sample. Returns when its last has been heard.
  std::uint64_t next(int samples, const std::stop_token& stop) {
    if (live_) {
      const auto heard =
          static_cast<std::int64_t>(clock_.now_us()) - std::int64_t{samples} * 1'000'000 / kRate;
      const std::int64_t off = heard - static_cast<std::int64_t>(time_us());
      if (samples_ == 0 || off > kMostOff || off < -kMostOff) {
        begin_us_ = static_cast<std::uint64_t>(heard);
        samples_ = 0;
      }
    }
    const std::uint64_t begin = time_us();
    samples_ += static_cast<std::uint64_t>(samples);
    if (!live_) clock_.wait_until(time_us(), stop);
    return begin;
  }

 private:
  std::uint64_t time_us() const { return begin_us_ + samples_ * 1'000'000 / kRate; }

  const bool live_;
  const LiveClock clock_ = LiveClock::system();
  std::uint64_t begin_us_, samples_ = 0;
};

struct Closing {
  int file;
  ~Closing() { close(); }
  void close() {
    if (file >= 0) ::close(std::exchange(file, -1));
  }
};

/// Returns what ffmpeg found wrong, if all the sound came; empty if nothing.
Result<std::string> send(const SoundSource& source, const OnSoundPacket& on_packet,
                         const std::stop_token& stop) {
  std::array<int, 2> ends{-1, -1};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) return fail(ErrorCode::io, errno_message());
  const Closing output{ends[0]};
  Closing input{ends[1]};
  Ffmpeg ffmpeg = TRY(Ffmpeg::start(arguments(source), {.output = input.file}));
  input.close();
  OggPackets packets;
  SoundTimes times(source);
  std::uint64_t sent_samples = 0;
  std::vector<std::uint8_t> part(1 << 12);
  while (wait_readable(output.file, stop)) {
    const ssize_t size = ::read(output.file, part.data(), part.size());
    if (size < 0 && errno == EINTR) continue;
    if (size <= 0) break;
    packets.add({part.data(), static_cast<std::size_t>(size)});
    packets.for_each([&](ByteView packet) {
      const int samples =
          opus_packet_get_nb_samples(packet.data(), static_cast<opus_int32>(packet.size()), kRate);
      if (stop.stop_requested() || samples <= 0 || samples > kMaxSoundSamples ||
          packet.size() > kMaxSoundPacket)
        return;
      const std::uint64_t begin = times.next(samples, stop);
      on_packet(packet, static_cast<std::uint16_t>(samples), begin);
      sent_samples += static_cast<std::uint64_t>(samples);
    });
  }
  if (stop.stop_requested()) return std::string();
  const bool ended_well = ffmpeg.wait();
  std::string said = ffmpeg.reason();
  if (source.name == kMicrophone) {
    if (ended_well && sent_samples > 0) return said;
    return fail(fmt::format("cannot be heard{}{}", said.empty() ? "" : ": ", said));
  }
  if (!ended_well) return tl::unexpected(unreadable_sound(said));
  const SoundEnd end = TRY(find_sound_end(source.name));
  TRY(end.check(sent_samples * 1'000'000 / kRate, end.end_us, said));
  return said;
}

}  // namespace

Result<void> check_sound(const std::string& name) {
  if (!is_installed("ffmpeg")) return fail(ErrorCode::not_found, kSoundNeedsFfmpeg);
  std::error_code error;
  if (name == kMicrophone) return {};
  if (!std::filesystem::is_regular_file(name, error))
    return fail(ErrorCode::not_found, name + ": is not a file that can be read");
  TRY(at_place(name, find_sound_end(name)));
  return {};
}

Result<std::string> send_sound(const SoundSource& source, const OnSoundPacket& on_packet,
                               const std::stop_token& stop) {
  return at_place(source.name, send(source, on_packet, stop));
}

}  // namespace pointreel
