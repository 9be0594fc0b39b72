#include "server/relay/live_sound_file.h"

#include <array>
#include <fstream>
#include <iterator>
#include <string_view>
#include <system_error>
#include <utility>

#include <ogg/ogg.h>
#include <opus/opus.h>

#include "common/base/byte_io.h"

namespace pointreel {
namespace {

constexpr int kRate = 48'000;
constexpr std::uint64_t kSilenceSamples = 960;
/// 20 ms of silence in both channels, as the format has it for lost packets.
constexpr std::array<std::uint8_t, 3> kSilence{0xfc, 0xff, 0xfe};
/// A gap that is longer is not filled: the publisher's clock has jumped.
constexpr std::uint64_t kLongestGap = std::uint64_t{3600} * kRate;

void put_text(Bytes& out, std::string_view text) {
  out.insert(out.end(), text.begin(), text.end());
}

Bytes head() {
  Bytes bytes;
  bytes.reserve(64);
  put_text(bytes, "OpusHead");
  ByteWriter out(bytes);
  out.put(std::uint8_t{1});
  out.put(std::uint8_t{2});   // channels
  out.put(std::uint16_t{0});  // samples to skip
  out.put(std::uint32_t{kRate});
  out.put(std::uint16_t{0});  // gain
  out.put(std::uint8_t{0});   // mono or stereo
  return bytes;
}

Bytes tags() {
  constexpr std::string_view kVendor = "Pointreel";
  Bytes bytes;
  bytes.reserve(64);
  put_text(bytes, "OpusTags");
  ByteWriter out(bytes);
  out.put(static_cast<std::uint32_t>(kVendor.size()));
  put_text(bytes, kVendor);
  out.put(std::uint32_t{0});
  return bytes;
}

}  // namespace

/// Packets to pages to a file.
class LiveSoundFile::Pages {
 public:
  explicit Pages(const std::filesystem::path& file)
      : out_(file, std::ios::binary | std::ios::trunc) {
    ogg_stream_init(&stream_, 1);
    // Each has a page of its own.
    for (const Bytes& packet : {head(), tags()}) {
      bytes_ += put(packet, 0);
      bytes_ += flush();
    }
  }
  ~Pages() { ogg_stream_clear(&stream_); }
  Pages(const Pages&) = delete;
  Pages& operator=(const Pages&) = delete;

  std::uint64_t head_bytes() const { return bytes_; }
  /// Returns how many bytes were written.
  std::uint64_t put(ByteView packet, std::uint64_t end) {
    ogg_packet entry{};
    entry.packet = const_cast<unsigned char*>(packet.data());
    entry.bytes = static_cast<long>(packet.size());
    entry.b_o_s = number_ == 0;
    entry.granulepos = static_cast<ogg_int64_t>(end);
    entry.packetno = number_++;
    ogg_stream_packetin(&stream_, &entry);
    return write(ogg_stream_pageout);
  }
  std::uint64_t flush() { return write(ogg_stream_flush); }

 private:
  std::uint64_t write(int (*next)(ogg_stream_state*, ogg_page*)) {
    std::uint64_t bytes = 0;
    ogg_page page;
    while (next(&stream_, &page) != 0) {
      out_.write(reinterpret_cast<const char*>(page.header), page.header_len);
      out_.write(reinterpret_cast<const char*>(page.body), page.body_len);
      bytes += static_cast<std::uint64_t>(page.header_len + page.body_len);
    }
    // What a killed program has not handed to the system is lost.
    if (bytes > 0) out_.flush();
    return bytes;
  }

  std::ofstream out_;
  ogg_stream_state stream_{};
  ogg_int64_t number_ = 0;
  std::uint64_t bytes_ = 0;
};

LiveSoundFile::LiveSoundFile(std::filesystem::path file, std::uint64_t start_us)
    : file_(std::move(file)), start_us_(start_us) {}

LiveSoundFile::~LiveSoundFile() {
  std::error_code ignored;
  if (pages_) std::filesystem::remove(file_, ignored);
}

void LiveSoundFile::put(ByteView packet, std::uint64_t samples) {
  if (!pages_) {
    pages_ = std::make_unique<Pages>(file_);
    written_ = pages_->head_bytes();
  }
  samples_ += samples;
  written_ += pages_->put(packet, samples_);
}

void LiveSoundFile::add(const LiveSound& sound) {
  const int samples = opus_packet_get_nb_samples(
      sound.packet.data(), static_cast<opus_int32>(sound.packet.size()), kRate);
  if (samples != sound.samples || sound.capture_us < start_us_ || written_ > kMostBytes) return;
  const std::uint64_t since = sound.capture_us - start_us_;
  const std::uint64_t first = since / 1'000'000 * kRate + since % 1'000'000 * kRate / 1'000'000;
  if (first + kSilenceSamples <= samples_ || first > samples_ + kLongestGap) return;
  while (first >= samples_ + kSilenceSamples) put(kSilence, kSilenceSamples);
  put(sound.packet, sound.samples);
}

Result<Bytes> LiveSoundFile::bytes() {
  if (!pages_) return Bytes{};
  written_ += pages_->flush();
  std::ifstream in(file_, std::ios::binary);
  Bytes bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  if (in.bad() || bytes.size() != written_)
    return fail(ErrorCode::io, file_.string() + ": the sound could not be written in full");
  return bytes;
}

}  // namespace pointreel
