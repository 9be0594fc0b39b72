#pragma once

#include <cstddef>

#include "codec/formats/byte_source.h"
#include "pointreel/cloud.h"
#include "pointreel/error.h"

namespace pointreel {

/// Reads a sweep of a laser scanner as data sets for driving store it: little-endian floats without
/// a header. Intensities and rings become scalar fields. KITTI's .bin files have four a point (x,
/// y, z, reflectance), and nuScenes' .pcd.bin files five (x, y, z, intensity, ring).
///
/// `floats`: 4 or 5, or 0 if the name does not tell. Then five are taken if four do not divide the
/// file, or if the fifth are rings, which are whole numbers below 256 and not all the same.
///
/// Errors: `invalid` if the size fits neither, or most of the first points are further away than
/// any scanner sees: then it is some other file.
///
/// Trust: the bytes may be hostile. Memory is bounded by their number.
Result<PointCloud> read_sweep(const ByteSource& source, std::size_t floats);

}  // namespace pointreel
