#pragma once

#include "pointreel/error.h"
#include "pointreel/package.h"

namespace pointreel {

/// A manifest without frames, to which `part` and those that go together with it can be added.
Manifest manifest_before(const Manifest& part);

/// Adds the segments of `part` behind those of `whole`, and makes what `whole` says about all of
/// its frames true of the new ones as well: bounds, depths, attributes, the error, cleaning. Frame
/// numbers are counted on; the times of the frames and `duration_us` stay as they are.
///
/// An error (`argument`) if frames of the two cannot be in one reel: codec, entropy, layers, the
/// axis that points up or the context tables differ.
Result<void> append_manifest(Manifest& whole, Manifest part);

}  // namespace pointreel
