#pragma once

#include <string>
#include <vector>

#include "codec/formats/byte_source.h"
#include "pointreel/cloud.h"
#include "pointreel/error.h"

namespace pointreel {

/// Reads text with a line for each point, as .xyz, .txt, .csv, .asc and .pts have it. Numbers are
/// separated by commas, by semicolons (then a comma may be the decimal point), or by blanks. Empty
/// lines, and lines that begin with '#', '//' or '%', are skipped.
///
/// The first line may name the columns, also as a comment ("//X Y Z R G B"); named_fields.h says
/// what is read of them. Without names, the number of columns decides:
///   3   x y z
///   4   x y z intensity
///   6   x y z, and r g b or a normal: normals are numbers below 0, or vectors of length 1
///   7   x y z r g b intensity, or x y z intensity r g b where only the last three are bytes
///   9   x y z r g b nx ny nz
///   10  x y z r g b nx ny nz intensity
/// With 5, 8 or more than 10 columns the first three count; others are scalar fields
/// "column 4" and so on, up to the tenth. In scalar fields, what is not a number is NaN. A line
/// with a single number before the first point is the count that .pts files begin with. Colours: as
/// records.h says.
///
/// The error names the line and the column. `unread` receives the names of what is skipped.
///
/// Trust: the bytes may be hostile. Memory is bounded by a constant times their number.
Result<PointCloud> read_text_points(const ByteSource& source, std::vector<std::string>& unread);

}  // namespace pointreel
