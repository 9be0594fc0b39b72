#pragma once

#include <cstddef>

#include "codec/core/triangle_mesh.h"

namespace pointreel {

/// Closes the holes with at most so many edges by a fan of triangles, where these face the way of
/// the normals around the hole. Edges have at most two triangles (`keep_manifold`).
void close_holes(TriangleMesh& mesh, std::size_t edges);

}  // namespace pointreel
