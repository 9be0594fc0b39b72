#pragma once

#include "codec/files/byte_source.h"
#include "codec/files/cloud_format.h"
#include "codec/files/read_notes.h"
#include "codec/files/reading.h"
#include "pointreel/cloud.h"
#include "pointreel/codec.h"
#include "pointreel/error.h"

namespace pointreel {

/// Reads the points of a file, which are not yet safe to use (`sanitize`). `name` is only used for
/// errors if the format is unknown. `notes` receives what there is to say about the
/// file.
///
/// Trust: the bytes may be hostile. Memory is bounded by a constant times their number, and where
/// few bytes may stand for many points, by `limits`.
Result<PointCloud> read_points(const ByteSource& source, CloudFormat format,
                               const DecodeLimits& limits, const Reading& reading,
                               ReadNotes& notes);

}  // namespace pointreel
