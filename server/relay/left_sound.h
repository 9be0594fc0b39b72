#pragma once

#include <cstddef>
#include <cstdint>

#include "pointreel/bytes.h"

namespace pointreel {

/// What can be used of a LiveSoundFile whose program was killed.
struct LeftSound {
  std::size_t bytes = 0;      ///< at its front: whole pages that end with a whole packet
  std::uint64_t samples = 0;  ///< in them, of each channel at 48,000 Hz; 0: there is no sound
};

/// Trust: the file may have been cut or damaged anywhere. Pages of Ogg have checksums, and what
/// follows the first that is wrong is left out. Packets are not decoded. Memory does not grow with
/// the file, and time grows with its size.
LeftSound find_left_sound(ByteView file);

}  // namespace pointreel
