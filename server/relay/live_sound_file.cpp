#include "server/relay/live_sound_file.h"

#include <fstream>
#include <iterator>
#include <system_error>
#include <utility>

#include <opus/opus.h>

namespace pointreel {
namespace {

constexpr int kRate = 48'000;
/// A gap that is longer is not filled: the publisher's clock has jumped.
constexpr std::uint64_t kLongestGap = std::uint64_t{3600} * kRate;

}  // namespace

LiveSoundFile::LiveSoundFile(std::filesystem::path file, std::uint64_t start_us)
    : file_(std::move(file)), start_us_(start_us) {}

LiveSoundFile::~LiveSoundFile() {
  std::error_code ignored;
  if (writer_) std::filesystem::remove(file_, ignored);
}

void LiveSoundFile::put(ByteView packet, std::uint64_t samples) {
  if (!writer_) writer_.emplace(file_, OpusReader::Head{});
  samples_ += samples;
  writer_->put(packet, samples_);
}

void LiveSoundFile::add(const LiveSound& sound) {
  const int samples = opus_packet_get_nb_samples(
      sound.packet.data(), static_cast<opus_int32>(sound.packet.size()), kRate);
  if (samples != sound.samples || sound.capture_us < start_us_ ||
      (writer_ && writer_->bytes() > kMostBytes))
    return;
  const std::uint64_t since = sound.capture_us - start_us_;
  const std::uint64_t first = since / 1'000'000 * kRate + since % 1'000'000 * kRate / 1'000'000;
  if (first + kOpusSilenceSamples <= samples_ || first > samples_ + kLongestGap) return;
  while (first >= samples_ + kOpusSilenceSamples) put(kOpusSilence, kOpusSilenceSamples);
  put(sound.packet, sound.samples);
}

Result<Bytes> LiveSoundFile::bytes() {
  if (!writer_) return Bytes{};
  writer_->flush();
  std::ifstream in(file_, std::ios::binary);
  Bytes bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  if (in.bad() || bytes.size() != writer_->bytes())
    return fail(ErrorCode::io, file_.string() + ": the sound could not be written in full");
  return bytes;
}

}  // namespace pointreel
