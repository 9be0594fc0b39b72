#pragma once

#include "client/source/fetched.h"
#include "pointreel/codec.h"
#include "pointreel/error.h"

namespace pointreel {

/// Decodes what was fetched of a frame: the layers of a package, or else a whole file, whose name
/// its errors begin with. A file has no tree; its cube is the bounding cube of its points. Of
/// `limits`, the tables are those of the package.
///
/// Trust: the bytes may be hostile; codec.h, draco.h and cloud_file.h say how they are read.
Result<DecodedFrame> decode_fetched(const FetchedFrame& fetched, DecodeLimits limits);

}  // namespace pointreel
