#include "client/sound/alsa_device.h"

#include <algorithm>
#include <cerrno>
#include <utility>

#include <alsa/asoundlib.h>
#include <fmt/format.h>

#include "common/base/try.h"

namespace pointreel {
namespace {

/// Little, so that jumps are soon heard, and enough for a machine that is busy drawing.
constexpr unsigned kBufferUs = 60'000;

class AlsaDevice : public AudioDevice {
 public:
  explicit AlsaDevice(snd_pcm_t* pcm) : pcm_(pcm) {}
  ~AlsaDevice() override { snd_pcm_close(pcm_); }

  Result<void> prepare() {
    TRY(checked(snd_pcm_set_params(pcm_, SND_PCM_FORMAT_FLOAT, SND_PCM_ACCESS_RW_INTERLEAVED, 2,
                                   kAudioRate, 1, kBufferUs)));
    snd_pcm_uframes_t buffer = 0, period = 0;
    TRY(checked(snd_pcm_get_params(pcm_, &buffer, &period)));
    buffer_ = static_cast<snd_pcm_sframes_t>(buffer);
    return {};
  }

  Result<State> state(TimePoint /*now*/) override {
    State state;
    snd_pcm_sframes_t room = snd_pcm_avail_update(pcm_);
    if (room < 0) {
      state.broken_off = true;
      TRY(recover(static_cast<int>(room)));
      room = snd_pcm_avail_update(pcm_);
    }
    if (room < 0) return failed(static_cast<int>(room));
    // Devices do not know it before they have played something.
    snd_pcm_sframes_t delay = 0;
    if (snd_pcm_delay(pcm_, &delay) < 0) delay = buffer_ - room;
    state.room = static_cast<std::size_t>(room);
    state.delay = static_cast<double>(std::max<snd_pcm_sframes_t>(0, delay));
    return state;
  }

  Result<void> write(std::span<const StereoSample> samples) override {
    while (!samples.empty()) {
      const snd_pcm_sframes_t written = snd_pcm_writei(pcm_, samples.data(), samples.size());
      if (written == -EAGAIN) return {};
      if (written < 0) {
        TRY(recover(static_cast<int>(written)));
      } else {
        samples = samples.subspan(static_cast<std::size_t>(written));
      }
    }
    if (snd_pcm_state(pcm_) == SND_PCM_STATE_PREPARED) return checked(snd_pcm_start(pcm_));
    return {};
  }

 private:
  static tl::unexpected<Error> failed(int error) {
    return fail(ErrorCode::io, snd_strerror(error));
  }
  static Result<void> checked(int error) {
    if (error < 0) return failed(error);
    return {};
  }
  Result<void> recover(int error) { return checked(snd_pcm_recover(pcm_, error, 1)); }

  snd_pcm_t* const pcm_;
  snd_pcm_sframes_t buffer_ = 0;  ///< how many samples can wait
};

void say_nothing(const char*, int, const char*, int, const char*, ...) {}

}  // namespace

Result<std::unique_ptr<AudioDevice>> open_alsa_device(const std::string& name) {
  // By default ALSA prints what it tries.
  snd_lib_error_set_handler(say_nothing);
  snd_pcm_t* pcm = nullptr;
  const int error = snd_pcm_open(&pcm, name.c_str(), SND_PCM_STREAM_PLAYBACK, SND_PCM_NONBLOCK);
  if (error < 0)
    return fail(ErrorCode::not_found, fmt::format("{}: {}", name, snd_strerror(error)));
  auto device = std::make_unique<AlsaDevice>(pcm);
  TRY(at_place(name, device->prepare()));
  return device;
}

}  // namespace pointreel
