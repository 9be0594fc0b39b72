#pragma once

#include <optional>
#include <span>

#include "codec/files/cloud_file.h"
#include "codec/segments/pack_options.h"

namespace pointreel {

/// Decides once for a sequence whether its noise is worth cleaning, by some of its frames: where it
/// is about at the limit, single frames that are cleaned would flicker among others that are not.
/// Sets CleanOptions::noisy, unless a radius is given, frames are not cleaned, there is only one,
/// or none of those that are looked at is a scan.
void choose_cleaning(std::span<const CloudFrame> frames, PackOptions& options);

/// What was decided, or is given: CleanOptions::noisy.
std::optional<bool> cleaning_choice(const PackOptions& options);

}  // namespace pointreel
