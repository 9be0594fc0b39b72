#pragma once

#include <vector>

#include <glm/glm.hpp>

#include "pointreel/cloud.h"

namespace pointreel {

/// A surface of triangles. The vertices are a cloud with normals, without radii and scalar fields,
/// and with colours if what the mesh was made of has any.
struct TriangleMesh {
  PointCloud vertices;
  std::vector<glm::uvec3> triangles;  ///< counter-clockwise as seen from outside

  bool empty() const { return triangles.empty(); }
};

}  // namespace pointreel
