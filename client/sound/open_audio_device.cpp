#include "client/sound/open_audio_device.h"

#include "client/sound/alsa_device.h"
#include "client/sound/null_device.h"

namespace pointreel {

Result<std::unique_ptr<AudioDevice>> open_audio_device(const std::string& name) {
  if (name == "null") return std::make_unique<NullDevice>();
  return open_alsa_device(name);
}

}  // namespace pointreel
