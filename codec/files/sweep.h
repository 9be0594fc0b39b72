#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "codec/files/byte_source.h"
#include "codec/files/read_notes.h"
#include "codec/files/reading.h"
#include "pointreel/cloud.h"
#include "pointreel/error.h"

namespace pointreel {

/// A part of a sweep that begins at a multiple of these bytes begins with a point, however many
/// floats a point has.
inline constexpr std::size_t kSweepUnit = sizeof(float) * 840;

/// Names for the floats of a point in sweeps of one sequence: the number of floats is one from 3 to
/// 8 that divides most of their `sizes` in bytes, and with which each float differs least from that
/// of the next point. None if no number does. `samples` are of sample.h.
///   3  x y z
///   4  x y z intensity, as in KITTI
///   5  x y z intensity, and ring, as in nuScenes, if these are whole numbers up to 255, or time;
///      nothing if it never varies
///   6  x y z, and r g b if these are whole numbers up to 255, or a normal of length 1
///   7  x y z intensity r g b, if the last three are whole numbers up to 255
/// Else, those behind the first five are "column 6" and so on; "time" may be the sixth, behind
/// ring.
std::vector<std::string> guess_sweep_columns(std::span<const std::uint64_t> sizes,
                                             std::span<const ByteView> samples);

/// The names for nuScenes' .pcd.bin files.
std::vector<std::string> nuscenes_columns();

/// Reads a sweep of a laser scanner as data sets for driving store it: little-endian floats without
/// a header, as many a point as the reading has columns. Without columns, they are guessed.
///
/// Errors: `invalid` if the size does not fit, or most of the first points are further away than
/// any scanner sees: then it is some other file.
///
/// Trust: the bytes may be hostile. Memory is bounded by their number.
Result<PointCloud> read_sweep(const ByteSource& source, const Reading& reading, ReadNotes& notes);

}  // namespace pointreel
