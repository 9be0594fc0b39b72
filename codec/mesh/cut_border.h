#pragma once

#include <span>

#include "codec/core/triangle_mesh.h"

namespace pointreel {

/// Cuts a mesh along the line where `beside` is 1, and keeps what is below. Vertices near the line
/// move onto it, so that no slivers remain. Values are smoothed first, because those of single
/// vertices depend on how points happen to lie.
void cut_border(TriangleMesh& mesh, std::span<const float> beside);

}  // namespace pointreel
