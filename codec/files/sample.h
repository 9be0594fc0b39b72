#pragma once

#include <optional>

#include "codec/files/byte_source.h"
#include "codec/files/cloud_format.h"
#include "pointreel/error.h"

namespace pointreel {

/// Bytes that are read like a file, but have only some of its points, from all over it: about 1 MiB
/// of them. Small files, and those of which no part can be taken, come as a whole. Nothing for
/// files that say themselves how they are read (reading.h), and have no field that may say nothing.
///
/// Trust: the bytes may be hostile. Memory is bounded by a constant times their number.
Result<std::optional<Bytes>> sample_of(const ByteSource& source, CloudFormat format);

}  // namespace pointreel
