#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "codec/files/byte_source.h"
#include "codec/files/read_notes.h"
#include "pointreel/bytes.h"
#include "pointreel/cloud.h"
#include "pointreel/codec.h"
#include "pointreel/error.h"

/// A picture of depth with what belongs to it, as one string of bytes (CloudFormat::depth_frame):
/// the sizes of the intrinsics and of the depth in four bytes each, little endian, and then the
/// intrinsics (camera_intrinsics.h), the depth and the colours (picture.h).
namespace pointreel {

/// `color` is empty where there are none. No part may be larger than 4 GiB.
Bytes depth_frame(std::string_view intrinsics, ByteView depth, ByteView color);

/// The points of such a frame, as depth_points.h says. The intrinsics may be those of a picture of
/// the same shape with another number of pixels, within 1 %, and so may be the colours; they are
/// left out if their shape differs. `notes` receives that, and whether the camera has distortion,
/// which is not undone. Errors name the part.
///
/// Trust: the bytes may be hostile. Memory is bounded by `limits` before it is taken: 64 bytes for
/// each pixel of depth, and 8 for each of colour, together.
Result<PointCloud> read_depth_frame(const ByteSource& source, const DecodeLimits& limits,
                                    ReadNotes& notes);

}  // namespace pointreel
