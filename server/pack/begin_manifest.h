#pragma once

#include "codec/files/cloud_file.h"
#include "pointreel/package.h"
#include "server/pack/packer.h"

namespace pointreel {

/// Whether frames are shown at the times that their files state, and not evenly.
bool has_times_of_files(const PackOptions& options, const CloudSequence& sequence);

/// What the manifest of a reel says of these frames before any of them is packed. If their files
/// state times, sets options.fps to the nominal rate of these.
Manifest begin_manifest(PackOptions& options, const CloudSequence& sequence);

}  // namespace pointreel
