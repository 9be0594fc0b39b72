#pragma once

#include <cstddef>

#include "codec/core/triangle_mesh.h"

namespace pointreel {

/// Reduces a mesh to at most `triangles`, where its shape allows that: it keeps the connection of
/// the surface, its parts and its holes (quadric error metrics, by meshoptimizer).
void simplify(TriangleMesh& mesh, std::size_t triangles);

/// Orders the triangles so that neighbours follow each other, which is fast to draw.
void order_for_drawing(TriangleMesh& mesh);

}  // namespace pointreel
