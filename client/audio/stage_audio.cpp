#include "client/audio/stage_audio.h"

#include <chrono>
#include <stop_token>
#include <utility>
#include <vector>

#include "client/audio/audio_track.h"
#include "client/audio/open_audio_device.h"

namespace pointreel {

using std::chrono::steady_clock;

StageAudio::StageAudio(std::optional<std::string> device, OnError on_error)
    : device_(std::move(device)), on_error_(std::move(on_error)) {}

StageAudio::~StageAudio() { begin(nullptr); }

void StageAudio::begin(Stage* stage) {
  thread_ = {};
  player_.reset();
  time_->let_go(steady_clock::now());
  stage_ = stage;
  if (!stage || !device_) return;
  std::vector<std::shared_ptr<AudioSamples>> sounds(stage->size());
  bool any = false;
  for (std::size_t i = 0; i < stage->size(); ++i) {
    const ReelPlayback* reel = stage->reel(i);
    if (!reel || !reel->manifest().audio) continue;
    any = true;
    sounds[i] = std::make_shared<AudioTrack>(
        *reel->manifest().audio,
        [reel](std::uint64_t offset, std::uint64_t size, const std::stop_token& stop) {
          return reel->fetch_audio(offset, size, stop);
        },
        [this, i](const Error& error) { on_error_(i, error); });
  }
  if (!any) return;
  player_ =
      std::make_unique<AudioPlayer>([name = *device_] { return open_audio_device(name); }, time_);
  player_->begin(sounds);
  thread_ = std::jthread([player = player_.get()](const std::stop_token& stop) {
    while (!stop.stop_requested() && player->pump(steady_clock::now()))
      std::this_thread::sleep_for(AudioPlayer::kPeriod);
  });
}

void StageAudio::follow(double volume) {
  if (!player_) return;
  player_->set_volume(volume);
  for (std::size_t i = 0; i < stage_->size(); ++i)
    if (const ReelPlayback* reel = stage_->reel(i)) player_->follow(i, reel->position());
}

std::optional<AudioPlayer::Statistics> StageAudio::statistics() const {
  if (!player_) return std::nullopt;
  return player_->statistics();
}

}  // namespace pointreel
