#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <stop_token>
#include <thread>
#include <vector>

#include "client/sound/audio_samples.h"
#include "pointreel/bytes.h"
#include "pointreel/error.h"
#include "pointreel/package.h"

namespace pointreel {

/// Fetches and decodes the sound of a reel on a thread of its own: what is wanted, and no more.
///
/// Trust: the bytes may be hostile (opus_reader.h). It keeps at most kMostBlocks blocks of samples
/// and a few pieces of the file.
class AudioTrack : public AudioSamples {
 public:
  /// Source::fetch_audio.
  using Fetch = std::function<Result<Bytes>(std::uint64_t offset, std::uint64_t size,
                                            const std::stop_token& stop)>;
  using OnError = std::function<void(const Error&)>;

  static constexpr std::int64_t kBlock = kAudioRate / 10;  ///< samples that are decoded together
  static constexpr std::size_t kMostBlocks = 64;

  /// `file` describes the sound. `on_error` is called by the thread, once if a part of the sound is
  /// damaged, which stays silent, and once if nothing more can be decoded; not if a fetch is
  /// cancelled.
  AudioTrack(const AudioFile& file, Fetch fetch, OnError on_error);
  /// Stops a fetch that is under way.
  ~AudioTrack() override = default;

  bool copy(std::int64_t first, std::span<StereoSample> to) override;
  void want(const std::vector<std::int64_t>& samples) override;

 private:
  using Block = std::vector<StereoSample>;

  void run(const std::stop_token& stop);
  Result<void> decode(const std::stop_token& stop);

  const AudioFile file_;
  const Fetch fetch_;
  const OnError on_error_;
  std::mutex mutex_;  ///< guards what follows
  std::condition_variable_any changed_;
  std::vector<std::int64_t> wanted_;      ///< numbers of blocks
  std::map<std::int64_t, Block> blocks_;  ///< by number
  std::jthread thread_;                   ///< last, because it uses everything above
};

/// Reads a file through `fetch` in pieces, of which it keeps the ones that were used last: opusfile
/// asks for a few bytes at a time.
OpusReader::ReadAt in_pieces(std::uint64_t size, AudioTrack::Fetch fetch, std::stop_token stop);

}  // namespace pointreel
