#pragma once

#include "codec/files/byte_source.h"
#include "codec/files/read_notes.h"
#include "pointreel/cloud.h"
#include "pointreel/codec.h"
#include "pointreel/error.h"

namespace pointreel {

/// Reads the vertices of a glTF 2.0 file: binary (.glb), or JSON (.gltf) with its buffers inside
/// (gltf_buffers.h puts them there). A mesh is there once for each node of the scene that shows it,
/// where that node puts it; files without scenes show all of their meshes. Positions, normals and
/// colours (COLOR_0, times the base colour of the material) are read, of any component type that
/// glTF allows, normalised or not, interleaved or sparse. Where others have colours, a primitive
/// without has the base colour of its material, and white without one; a primitive without normals
/// has none. Vertices that no index names count, too. In glTF y points up.
///
/// `notes` receives what makes a difference and is skipped: "textures", "skins", "animations",
/// "morph targets", extensions. Errors name the part of the JSON: `unsupported` for buffers in
/// other files, for compressed primitives (Draco, meshopt) and for other extensions that the file
/// needs; the message says what to do. Source: "glTF 2.0 Specification", Khronos Group, 2.0.1.
///
/// Trust: the bytes may be hostile. Memory is bounded by a constant times their number, and where
/// nodes show a mesh again, by `limits`. obj.h says why assimp does not read them.
Result<PointCloud> read_gltf(const ByteSource& source, const DecodeLimits& limits,
                             ReadNotes& notes);

}  // namespace pointreel
