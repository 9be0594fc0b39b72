#pragma once

#include <span>
#include <string>
#include <vector>

#include "codec/files/byte_source.h"
#include "codec/files/read_notes.h"
#include "codec/files/reading.h"
#include "pointreel/cloud.h"
#include "pointreel/error.h"

namespace pointreel {

/// Names for the columns of text files of one sequence, of which some have none: those of a file
/// that has them, if they are as many, or else by their number and by what stands in them. None if
/// all have names. `samples` are of sample.h.
///   3   x y z
///   4   x y z intensity
///   6   x y z, and r g b or a normal: normals are numbers below 0, or vectors of length 1
///   7   x y z r g b intensity, or x y z intensity r g b where only the last three are bytes, or
///       x y z nx ny nz intensity, or x y z intensity nx ny nz
///   9   x y z r g b nx ny nz, or x y z nx ny nz r g b; without normals, the last three have no
///       names
///   10  the same and an intensity: behind them, or between or before them if the others then are
///       bytes and vectors of length 1
/// With 8 or more than 10 columns, bytes of which some are above 100 are colours behind x y z, or
/// behind an intensity. All others, and those of 5 columns, are "column 4" and so on. In .pts files
/// (`pts`, or those that begin with a count) 6 are x y z r g b, and 7 x y z intensity r g b, unless
/// the numbers are none of colours. `counts`: whether the first column numbers the points, so that
/// it hardly is x.
std::vector<std::string> guess_text_columns(std::span<const ByteView> samples, bool pts,
                                            bool& counts);

/// Reads text with a line for each point, as .xyz, .txt, .csv, .asc, .pts and the like have it.
/// Numbers are separated by commas, by semicolons, or by blanks; where commas do not separate, they
/// may be the decimal point. Empty lines, and lines that begin with '#', '//' or '%', are skipped.
///
/// The columns are named by the reading, or else by the first line, also as a comment ("//X Y Z R G
/// B"), or else guessed; named_fields.h says what is read of them. In scalar fields, what is not a
/// number is NaN. A line with a single number before the first point is the count that .pts files
/// begin with.
///
/// The error names the line and the column. `notes` receives the names of columns that are skipped.
///
/// Trust: the bytes may be hostile. Memory is bounded by a constant times their number.
Result<PointCloud> read_text_points(const ByteSource& source, const Reading& reading,
                                    ReadNotes& notes);

}  // namespace pointreel
