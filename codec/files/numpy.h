#pragma once

#include <cstddef>

#include "codec/files/byte_source.h"
#include "codec/files/column_guess.h"
#include "codec/files/read_notes.h"
#include "codec/files/reading.h"
#include "pointreel/cloud.h"
#include "pointreel/codec.h"
#include "pointreel/error.h"

namespace pointreel {

/// Reads the arrays of one cloud that numpy has saved: .npy, which is one array, or .npz, which are
/// several in a zip archive, compressed or not.
///
/// Positions are the array called positions, points, xyz, vertices or the like, of the shape
/// (N, 3); without such a name, the only array of at least three columns. Where it has more
/// columns, they are named by the reading, or else guessed as those of text (text_points.h). Other
/// arrays of N rows: colors or rgb (N, 3 or 4), normals (N, 3), and numbers (N), which are read by
/// their names like the columns of text; so are the fields of structured arrays. Numbers are whole
/// or floats of 16 to 64 bits, in either order of bytes.
///
/// The error names the array and its shape. `notes` receives the names of arrays that are skipped.
/// Source: "A simple file format for NumPy arrays", NumPy Enhancement Proposal 1.
///
/// Trust: the bytes may be hostile. Memory is bounded by a constant times their number, and by
/// `limits` where an archive is compressed. Pickled objects are never read.
Result<PointCloud> read_numpy(const ByteSource& source, const DecodeLimits& limits,
                              const Reading& reading, ReadNotes& notes);

/// Shows some rows of the positions to `guess` if they have more than three columns. Returns how
/// many they have; 0 where the file cannot be read.
std::size_t look_at_numpy(const ByteSource& source, const DecodeLimits& limits, ColumnGuess& guess);

}  // namespace pointreel
