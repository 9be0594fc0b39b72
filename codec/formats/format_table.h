#pragma once

#include <string>
#include <vector>

#include "codec/formats/byte_source.h"
#include "codec/formats/cloud_format.h"
#include "pointreel/cloud.h"
#include "pointreel/codec.h"
#include "pointreel/error.h"

namespace pointreel {

/// Reads the points of a file, which are not yet safe to use (`sanitize`). `name` is only used for
/// errors if the format is unknown. `unread` receives the names of what is skipped.
///
/// Trust: the bytes may be hostile. Memory is bounded by a constant times their number, and where
/// few bytes may stand for many points, by `limits`.
Result<PointCloud> read_points(const ByteSource& source, CloudFormat format,
                               const DecodeLimits& limits, std::vector<std::string>& unread);

}  // namespace pointreel
