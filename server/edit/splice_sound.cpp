#include "server/edit/splice_sound.h"

#include <algorithm>
#include <array>
#include <deque>
#include <fstream>
#include <functional>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "codec/audio/opus_reader.h"
#include "codec/audio/opus_writer.h"
#include "common/base/try.h"
#include "common/base/words.h"
#include "common/file_system/open_file.h"
#include "common/file_system/output_folder.h"

namespace pointreel {
namespace fs = std::filesystem;
namespace {

using Packet = OpusReader::Packet;

/// That much sound comes before the first sample, for the decoder to be right by then. 80 ms are
/// the least (RFC 7845, 4.2), and leave an error of 3 %; after 400 ms it is below a millionth.
constexpr std::int64_t kWarmUp = 19'200;
/// The header of a file has 16 bits for it.
constexpr std::int64_t kMostSkipped = 65535;

/// Silence of 2.5, 5 and 10 ms, and the longest of 20.
struct Silence {
  std::array<std::uint8_t, 3> packet;
  std::int64_t samples;
};
constexpr std::array<Silence, 4> kSilences{{{kOpusSilence, kOpusSilenceSamples},
                                            {{0xf4, 0xff, 0xfe}, 480},
                                            {{0xec, 0xff, 0xfe}, 240},
                                            {{0xe4, 0xff, 0xfe}, 120}}};

/// Writes packets, each of which begins where the one before ends.
class Sound {
 public:
  explicit Sound(fs::path file) : file_(std::move(file)) {}

  bool begun() const { return writer_.has_value(); }
  const OpusReader::Head& head() const { return head_; }
  void begin(const OpusReader::Head& head) {
    head_ = head;
    writer_.emplace(file_, head);
  }

  /// Samples so far, with those that are not heard.
  std::int64_t end() const { return end_; }

  /// `heard`: how many of its samples are, if it is the last.
  Result<void> put(Packet packet, std::int64_t heard) {
    TRY(put_waiting());
    end_ += packet.samples;
    heard_end_ = end_ - packet.samples + heard;
    waiting_ = std::move(packet.bytes);
    return {};
  }

  /// As much as fits before a sample.
  Result<void> put_silence(std::int64_t until) {
    // Each packet takes a byte more, in a table of its page.
    const std::int64_t packets = (until - end_) / kSilences[0].samples;
    if (static_cast<std::uint64_t>(std::max<std::int64_t>(packets, 0)) > kMaxAudioBytes / 4)
      return too_long();
    for (const Silence& silence : kSilences) {
      for (; end_ + silence.samples <= until;) {
        Packet packet;
        packet.bytes.assign(silence.packet.begin(), silence.packet.end());
        packet.samples = static_cast<std::uint32_t>(silence.samples);
        TRY(put(std::move(packet), silence.samples));
      }
    }
    return {};
  }

  /// What comes after that many samples is not heard. Nothing if no sample is.
  Result<std::optional<AudioFile>> finish(std::int64_t most) {
    const std::int64_t heard = std::min(heard_end_, most);
    if (heard <= head_.skip) {
      std::error_code ignored;
      fs::remove(file_, ignored);
      return std::nullopt;
    }
    writer_->put(waiting_, static_cast<std::uint64_t>(heard), true);
    writer_->flush();
    AudioFile audio;
    audio.samples = static_cast<std::uint64_t>(heard - head_.skip);
    audio.bytes = writer_->bytes();
    audio.checksum = writer_->checksum();
    audio.path = fmt::format("audio.{:08x}.opus", audio.checksum >> 32);
    if (!writer_->good()) return cannot_write();
    writer_.reset();
    if (audio.bytes > kMaxAudioBytes) return too_long();
    std::error_code error;
    fs::rename(file_, file_.parent_path() / audio.path, error);
    if (error) return cannot_write();
    return audio;
  }

 private:
  Result<void> put_waiting() {
    if (waiting_.empty()) return {};
    writer_->put(waiting_, static_cast<std::uint64_t>(end_));
    if (writer_->bytes() > kMaxAudioBytes) return too_long();
    return {};
  }
  static tl::unexpected<Error> too_long() {
    return fail(ErrorCode::limit, fmt::format("the sound would take more than {} bytes; make "
                                              "shorter packages, or remove the sound with "
                                              "pointreel-server audio REEL --remove",
                                              kMaxAudioBytes));
  }
  tl::unexpected<Error> cannot_write() const {
    return fail(ErrorCode::io,
                file_.string() + ": cannot be written; check that the disk is not full");
  }

  const fs::path file_;
  OpusReader::Head head_;
  std::optional<OpusWriter> writer_;
  Bytes waiting_;  ///< the newest packet, which may be the last
  std::int64_t end_ = 0, heard_end_ = 0;
};

/// Adds a piece to the sound.
class PieceReader {
 public:
  PieceReader(const SoundPiece& piece, Sound& sound, const std::stop_token& stop)
      : piece_(piece), sound_(sound), stop_(stop) {}

  /// `is_last`: its end is exact.
  Result<void> copy(bool is_last) {
    std::error_code error;
    const std::uintmax_t size = fs::file_size(piece_.file, error);
    if (error) return fail(ErrorCode::io, error.message());
    if (size != piece_.bytes)
      return fail(fmt::format("has {}, the manifest says {}", counted(size, "byte"), piece_.bytes));
    std::ifstream file = TRY(open_stream(piece_.file));
    OpusReader reader = TRY(OpusReader::open(OpusReader::read_at(file), piece_.bytes));
    if (!reader.head().plain)
      return fail(ErrorCode::argument,
                  "has more channels than two, and cannot be copied" + advice());
    head_ = reader.head();
    if (sound_.begun() && !goes_together()) {
      return fail(ErrorCode::argument,
                  "has another gain or number of channels than the sound before it" + advice());
    }
    for (;;) {
      OpusReader::Packets read = TRY(reader.packets());
      if (stop_.stop_requested()) return fail(ErrorCode::cancelled, kInterrupted);
      if (read.hole) return fail("is damaged" + advice());
      if (read.packets.empty()) return {};
      for (Packet& packet : read.packets) {
        if (!TRY(take(std::move(packet), is_last))) return {};
      }
    }
  }

 private:
  static std::string advice() {
    return "; replace or remove it with pointreel-server audio, and try again";
  }
  bool goes_together() const {
    return head_.gain == sound_.head().gain && head_.channels == sound_.head().channels;
  }
  std::int64_t first() const { return static_cast<std::int64_t>(piece_.first); }

  /// Takes one packet after another. False once the piece is complete.
  Result<bool> take(Packet packet, bool is_last) {
    const std::int64_t packet_end = packet.first + packet.samples;
    if (!sound_.begun() && piece_.begin == 0) return lead(std::move(packet), is_last);
    if (packet_end <= first()) return true;
    if (!sound_.begun()) {
      head_.skip = 0;
      sound_.begin(head_);
    }
    return put(std::move(packet), is_last);
  }

  /// Before the very first sample, there are packets for the decoder to warm up.
  Result<bool> lead(Packet packet, bool is_last) {
    const bool reached = packet.first + packet.samples > first();
    leading_.push_back(std::move(packet));
    while (leading_.size() > 1 &&
           (leading_[1].first <= first() - kWarmUp || leading_[0].first < first() - kMostSkipped)) {
      leading_.pop_front();
    }
    if (!reached) return true;
    head_.skip = static_cast<std::uint32_t>(
        std::clamp<std::int64_t>(first() - leading_.front().first, 0, kMostSkipped));
    sound_.begin(head_);
    for (Packet& one : leading_) {
      if (!TRY(put(std::move(one), is_last))) return false;
    }
    return true;
  }

  Result<bool> put(Packet packet, bool is_last) {
    const std::int64_t samples = packet.samples;
    const std::int64_t at = packet.first - first() + place(piece_.begin);
    const std::int64_t heard = std::min(packet.end - packet.first, samples);
    const std::int64_t end = place(piece_.end);
    if (is_last ? at >= end || sound_.end() >= end : at + samples / 2 >= end) return false;
    if (at + samples / 2 < sound_.end()) return true;
    TRY(sound_.put_silence(at + kSilences.back().samples / 2));
    TRY(sound_.put(std::move(packet), heard));
    return true;
  }

  std::int64_t place(std::uint64_t sample) const {
    return static_cast<std::int64_t>(sample) + sound_.head().skip;
  }

  const SoundPiece& piece_;
  Sound& sound_;
  const std::stop_token& stop_;
  OpusReader::Head head_;
  std::deque<Packet> leading_;
};

}  // namespace

Result<std::optional<AudioFile>> splice_sound(std::span<const SoundPiece> pieces,
                                              const fs::path& folder, const std::stop_token& stop) {
  Sound sound(folder / "sound");
  std::int64_t end = 0;
  for (const SoundPiece& piece : pieces) {
    const bool is_last = &piece == &pieces.back();
    TRY(at_place(piece.shown, PieceReader(piece, sound, stop).copy(is_last)));
    end = static_cast<std::int64_t>(piece.end);
  }
  if (!sound.begun()) return std::nullopt;
  return sound.finish(end + sound.head().skip);
}

}  // namespace pointreel
