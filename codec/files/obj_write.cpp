#include "codec/files/obj_write.h"

#include <iterator>

#include <fmt/format.h>

namespace pointreel {

Bytes obj_bytes(const TriangleMesh& mesh) {
  const PointCloud& vertices = mesh.vertices;
  Bytes bytes;
  const auto out = std::back_inserter(bytes);
  // Digits that tell all floats apart, and millimetres on maps.
  const int digits = vertices.origin == glm::dvec3(0.0) ? 9 : 12;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const glm::dvec3 p = vertices.world(i);
    fmt::format_to(out, "v {:.{}g} {:.{}g} {:.{}g}", p.x, digits, p.y, digits, p.z, digits);
    if (vertices.has_colors()) {
      const glm::dvec3 color = glm::dvec3(vertices.colors[i]) / 65535.0;
      fmt::format_to(out, " {:.5g} {:.5g} {:.5g}", color.x, color.y, color.z);
    }
    bytes.push_back('\n');
  }
  for (const glm::vec3& n : vertices.normals)
    fmt::format_to(out, "vn {:.5g} {:.5g} {:.5g}\n", n.x, n.y, n.z);
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::uvec3 f = t + 1u;
    fmt::format_to(out, "f {}//{} {}//{} {}//{}\n", f.x, f.x, f.y, f.y, f.z, f.z);
  }
  return bytes;
}

}  // namespace pointreel
