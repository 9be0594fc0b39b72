#pragma once

#include <memory>
#include <string>

#include "client/sound/audio_device.h"

namespace pointreel {

/// The device of ALSA of this name (open_alsa_device), or "null", which nobody hears and which
/// keeps the machine's time.
Result<std::unique_ptr<AudioDevice>> open_audio_device(const std::string& name);

}  // namespace pointreel
