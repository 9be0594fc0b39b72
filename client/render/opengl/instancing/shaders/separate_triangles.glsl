// Strips and fans, drawn as separate triangles: all solids in one draw call.
const int kTriangles = kVertices - 2;

int solid_of(int vertex) { return vertex / (3 * kTriangles); }

// The number of a vertex in the strip or fan of its solid.
int number_in_solid(int vertex) {
  int triangle = vertex / 3 % kTriangles, corner = vertex % 3;
  if (kIsFan) return corner == 0 ? 0 : triangle + corner;
  // Every other triangle of a strip has the opposite order.
  return triangle % 2 == 1 && corner < 2 ? triangle + 1 - corner : triangle + corner;
}
