#include "client/sound/audio_passes.h"

#include <algorithm>
#include <utility>

#include "codec/audio/audio_time.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

constexpr std::uint64_t kMicroseconds = 1'000'000;

}  // namespace

Result<AudioPasses> AudioPasses::open(const AudioFile& file, AudioTrack::Fetch fetch,
                                      std::uint64_t duration_us, std::stop_token stop) {
  OpusReader reader =
      TRY(OpusReader::open(in_pieces(file.bytes, std::move(fetch), std::move(stop)), file.bytes));
  return AudioPasses(std::move(reader), file.samples, std::max<std::uint64_t>(1, duration_us));
}

Result<void> AudioPasses::read(std::uint64_t first, std::span<StereoSample> to) {
  while (!to.empty()) {
    // The pass that the sample belongs to begins at or before it, and the next one after it.
    const std::uint64_t time_us =
        first / kAudioRate * kMicroseconds + first % kAudioRate * kMicroseconds / kAudioRate;
    std::uint64_t pass = time_us / duration_us_;
    if (first_sample_from((pass + 1) * duration_us_) <= first) ++pass;
    const std::uint64_t begin = first_sample_from(pass * duration_us_);
    const std::uint64_t end = first_sample_from((pass + 1) * duration_us_);
    const std::uint64_t size = std::min<std::uint64_t>(to.size(), std::max(end, first + 1) - first);
    TRY(read_pass(first - begin, to.first(size)));
    to = to.subspan(size);
    first += size;
  }
  return {};
}

Result<void> AudioPasses::read_pass(std::uint64_t first, std::span<StereoSample> to) {
  std::fill(to.begin(), to.end(), StereoSample{});
  const std::uint64_t end = std::min(first + to.size(), samples_);
  if (first >= end) return {};
  return read_exactly(reader_, first, to.first(end - first));
}

}  // namespace pointreel
