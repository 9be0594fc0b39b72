#pragma once

#include "codec/files/byte_source.h"
#include "codec/files/read_notes.h"
#include "pointreel/cloud.h"
#include "pointreel/error.h"

namespace pointreel {

/// Reads PCD files of the Point Cloud Library, versions 0.5 to 0.7: ascii, binary and
/// binary_compressed; fields in any order and of any size and type. named_fields.h says what is
/// read of them, and records.h how numbers become positions and colours. Points that were not
/// measured (NaN) remain in the cloud. Points stay where they are, whatever VIEWPOINT says: it
/// tells from where they were seen, not where they belong.
///
/// The error names the line (header, ascii) or the byte (binary). `notes` receives the names
/// of what is skipped: other fields, and VIEWPOINT unless it is the origin. Lines with unknown
/// keywords are skipped with a warning; case does not matter in keywords.
/// Source: "The PCD (Point Cloud Data) file format", pointclouds.org.
///
/// Trust: the bytes may be hostile. Memory is bounded by a constant times their number, whatever
/// the header says: LZF makes at most 90 bytes of one.
Result<PointCloud> read_pcd(const ByteSource& source, ReadNotes& notes);

}  // namespace pointreel
