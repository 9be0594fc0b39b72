#include "client/sound/stage_audio.h"

#include <algorithm>
#include <chrono>
#include <stop_token>
#include <utility>
#include <vector>

#include "client/sound/audio_track.h"
#include "client/sound/open_audio_device.h"
#include "common/base/unix_time.h"

namespace pointreel {

using std::chrono::steady_clock;

StageAudio::StageAudio(std::optional<std::string> device, OnError on_error)
    : device_(std::move(device)), on_error_(std::move(on_error)) {}

StageAudio::~StageAudio() { begin(nullptr); }

void StageAudio::begin(Stage* stage) {
  thread_ = {};
  player_.reset();
  time_->let_go(steady_clock::now());
  sounds_.clear();
  live_.clear();
  stage_ = stage;
  if (!stage || !device_) return;
  sounds_.resize(stage->size());
  live_.resize(stage->size());
  bool any = false;
  for (std::size_t i = 0; i < stage->size(); ++i) {
    if (LivePlayback* live = stage->live(i)) {
      live_[i] = std::make_shared<LiveTrack>();
      sounds_[i] = live_[i];
      live->set_on_sound(
          [track = live_[i]](const LiveSound& sound) { track->add(sound, unix_time_us()); });
    }
    const ReelPlayback* reel = stage->reel(i);
    if (!reel || !reel->manifest().audio) continue;
    any = true;
    sounds_[i] = std::make_shared<AudioTrack>(
        *reel->manifest().audio,
        [reel](std::uint64_t offset, std::uint64_t size, const std::stop_token& stop) {
          return reel->fetch_audio(offset, size, stop);
        },
        [this, i](const Error& error) { on_error_(i, error); });
  }
  if (any) start();
}

void StageAudio::start() {
  player_ =
      std::make_unique<AudioPlayer>([name = *device_] { return open_audio_device(name); }, time_);
  player_->begin(sounds_);
  thread_ = std::jthread([player = player_.get()](const std::stop_token& stop) {
    while (!stop.stop_requested() && player->pump(steady_clock::now()))
      std::this_thread::sleep_for(AudioPlayer::kPeriod);
  });
}

void StageAudio::follow(double volume) {
  // Live streams say nothing of their sound before they send some.
  const bool heard = std::any_of(live_.begin(), live_.end(),
                                 [](const auto& track) { return track && track->begun(); });
  if (!player_ && heard) start();
  if (!player_) return;
  player_->set_volume(volume);
  const Clock::TimePoint now = time_->at(steady_clock::now());
  for (std::size_t i = 0; i < stage_->size(); ++i) {
    if (const ReelPlayback* reel = stage_->reel(i)) player_->follow(i, reel->position());
    if (!live_[i]) continue;
    const LivePlayback& live = *stage_->live(i);
    auto clock = live_[i]->clock(now, unix_time_us(), live.delay_us());
    if (!clock) continue;
    if (!live.playing()) clock->pause(now);
    player_->follow(i, *clock);
  }
}

std::optional<AudioPlayer::Statistics> StageAudio::statistics() const {
  if (!player_) return std::nullopt;
  AudioPlayer::Statistics statistics = player_->statistics();
  for (const auto& track : live_) {
    if (!track || !track->begun() || statistics.capture_to_sound_ms) continue;
    statistics.capture_to_sound_ms = 1e-3 * static_cast<double>(track->delay_us());
    statistics.gaps = track->gaps();
  }
  return statistics;
}

}  // namespace pointreel
