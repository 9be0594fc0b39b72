#pragma once

#include <cstddef>

#include "codec/core/triangle_mesh.h"

namespace pointreel {

/// Removes connected parts with fewer triangles than `least`, unless no part has more.
void remove_specks(TriangleMesh& mesh, std::size_t least);

/// Removes the vertices that no triangle has, and puts the others into the order in which triangles
/// need them.
void remove_unused_vertices(TriangleMesh& mesh);

/// Removes triangles without an area, and those that face against the normals of their vertices:
/// folds where sheets come too close to each other.
void remove_folds(TriangleMesh& mesh);

/// Removes triangles until every edge has at most two, on different sides.
void keep_manifold(TriangleMesh& mesh);

}  // namespace pointreel
