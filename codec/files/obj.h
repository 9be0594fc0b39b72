#pragma once

#include "codec/files/byte_source.h"
#include "codec/files/read_notes.h"
#include "pointreel/cloud.h"
#include "pointreel/error.h"

namespace pointreel {

/// Reads the vertices of a Wavefront OBJ file: "v x y z", optionally with a colour behind it
/// ("r g b", as most programs write it), and normals. A vertex has the mean of the normals that
/// faces give it; if nothing refers to the normals and there are as many as vertices, they belong
/// together in their order. A vertex has no colour if any vertex has none. Everything else is
/// skipped, and so are faces that name vertices or normals that are not there, with a warning.
///
/// The error names the line. assimp, which reads OBJ and glTF, too, is not used: in the version of
/// Debian 12 its importers read and write beyond their buffers on damaged files (CVE-2022-38528,
/// CVE-2024-40724, CVE-2024-48423).
///
/// Trust: the bytes may be hostile. Memory is bounded by a constant times their number.
Result<PointCloud> read_obj(const ByteSource& source, ReadNotes& notes);

}  // namespace pointreel
