#include "codec/mesh/simplify.h"

#include <vector>

#include <meshoptimizer.h>

#include "codec/mesh/tidy.h"

namespace pointreel {
namespace {

/// The indices of all triangles, as meshoptimizer wants them.
unsigned* indices_of(TriangleMesh& mesh) { return &mesh.triangles.data()->x; }

}  // namespace

void simplify(TriangleMesh& mesh, std::size_t triangles) {
  if (mesh.triangles.size() <= triangles) return;
  std::vector<glm::uvec3> reduced(mesh.triangles.size());
  const std::size_t indices =
      meshopt_simplify(&reduced.data()->x, indices_of(mesh), 3 * mesh.triangles.size(),
                       &mesh.vertices.positions.data()->x, mesh.vertices.size(), sizeof(glm::vec3),
                       3 * triangles, 1.0f, 0, nullptr);
  reduced.resize(indices / 3);
  mesh.triangles = std::move(reduced);
  remove_folds(mesh);
  remove_unused_vertices(mesh);
}

void order_for_drawing(TriangleMesh& mesh) {
  if (mesh.empty()) return;
  meshopt_optimizeVertexCache(indices_of(mesh), indices_of(mesh), 3 * mesh.triangles.size(),
                              mesh.vertices.size());
  remove_unused_vertices(mesh);
}

}  // namespace pointreel
