#pragma once

#include "codec/files/cloud_file.h"
#include "codec/files/reading.h"

namespace pointreel {

/// Decides how the frames of a sequence are read, where their files do not tell it: by parts of
/// some of them, and by the sizes of all sweeps. What is `asked` for is not guessed. Frames that
/// cannot be read are left to whoever reads them.
///
/// Trust: the files may be hostile. Memory and time are bounded by a constant times the largest
/// frame, of which no more than 9 are looked at.
void guess_reading(CloudSequence& sequence, const Reading& asked);

}  // namespace pointreel
