#pragma once

#include "codec/core/triangle_mesh.h"
#include "pointreel/bytes.h"

namespace pointreel {

/// The mesh as a Wavefront OBJ file in world coordinates, with normals. Colours follow the
/// coordinates of their vertices as numbers from 0 to 1, sRGB, which most programs read.
Bytes obj_bytes(const TriangleMesh& mesh);

}  // namespace pointreel
