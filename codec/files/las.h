#pragma once

#include "codec/files/byte_source.h"
#include "codec/files/read_notes.h"
#include "pointreel/cloud.h"
#include "pointreel/error.h"

namespace pointreel {

/// Reads LAS files, versions 1.0 to 1.4, point formats 0 to 10: positions, colours where the format
/// has them, of 16 bits or of 8 (records.h says how they are told apart), and the scalar fields
/// "intensity", "return number", "classification" and "infrared". All points are read, whatever
/// they are classified as. `notes` receives what is skipped: scan angles, GPS time, "extra bytes",
/// and so on. If the header counts fewer points than there are, there is a warning. Variable length
/// records are not looked at. In LAS files z points up.
///
/// Errors: `unsupported` for LAZ; the message says how to convert it.
/// Source: "LAS Specification 1.4 - R15", ASPRS, 2019.
///
/// Trust: the bytes may be hostile. Memory is bounded by a constant times their number, whatever
/// the header says.
Result<PointCloud> read_las(const ByteSource& source, ReadNotes& notes);

}  // namespace pointreel
