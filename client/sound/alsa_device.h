#pragma once

#include <memory>
#include <string>

#include "client/sound/audio_device.h"

namespace pointreel {

/// A device of ALSA, by its name. "default" is what the user hears: a card, or PulseAudio or
/// PipeWire where they run (their packages bring the plugins for ALSA). Prints nothing. Errors:
/// `not_found` if there is no such device; `io`.
Result<std::unique_ptr<AudioDevice>> open_alsa_device(const std::string& name);

}  // namespace pointreel
