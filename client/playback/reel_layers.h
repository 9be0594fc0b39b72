#pragma once

#include <cstdint>
#include <vector>

#include "client/playback/layer_control.h"
#include "client/prepare/prepare.h"
#include "pointreel/package.h"

namespace pointreel {

/// FrameBuffer::Options::levels for a reel. As many entries as its frames have layers; one for
/// files. The layer of scalar fields counts as finer than the finest level.
std::vector<int> levels_of(const Manifest& manifest);

/// `threads`: how many make frames. `link`: the reel comes over one.
LayerControl::Options control_options(const Manifest& manifest, unsigned threads, bool link);

/// What is fetched of frames that are prepared in this way, without regard to link and machine.
LayerDecision wanted_layers(const Manifest& manifest, const PrepareOptions& options);

/// LayerControl::Situation::bytes of a segment, with the attributes of `most`; empty for files.
std::vector<double> rung_bytes(const Manifest& manifest, std::uint32_t index,
                               const LayerRange& most);

}  // namespace pointreel
