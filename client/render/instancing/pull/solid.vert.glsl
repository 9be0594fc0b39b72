// A vertex of a listed solid. Its strip or fan is drawn as separate triangles.
layout(std430, binding = 4) readonly buffer Solids { Element solids[]; };

void main() {
  const int triangles = kVertices - 2;
  int triangle = gl_VertexID / 3 % triangles, corner = gl_VertexID % 3;
  int number = triangle + corner;
  if (kIsFan) {
    if (corner == 0) number = 0;
  } else if (triangle % 2 == 1 && corner < 2) {
    number = triangle + 1 - corner;  // every other triangle of a strip has the opposite order
  }
  set_vertex(solids[gl_VertexID / (3 * triangles)], number);
}
