#pragma once

#include <cstdint>
#include <span>
#include <stop_token>

#include "client/sound/audio_track.h"

namespace pointreel {

/// The sound of a reel that is played again and again, sample by sample, however long it takes to
/// fetch: for recordings. Sample n of the first pass is n / kAudioRate seconds from the reel's
/// start, and each pass takes exactly `duration_us`.
class AudioPasses {
 public:
  /// A fetch fails soon if it is asked to stop.
  static Result<AudioPasses> open(const AudioFile& file, AudioTrack::Fetch fetch,
                                  std::uint64_t duration_us, std::stop_token stop = {});

  /// The samples from number `first` on, counted through all passes. Where the reel has no sound,
  /// or it is damaged, is silence. Fast if calls follow on one another.
  Result<void> read(std::uint64_t first, std::span<StereoSample> to);

 private:
  AudioPasses(OpusReader reader, std::uint64_t samples, std::uint64_t duration_us)
      : reader_(std::move(reader)), samples_(samples), duration_us_(duration_us) {}

  Result<void> read_pass(std::uint64_t first, std::span<StereoSample> to);

  OpusReader reader_;
  std::uint64_t samples_ = 0, duration_us_ = 0;
};

}  // namespace pointreel
