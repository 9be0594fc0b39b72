// A vertex of an instance that is too large for a GL point. Its strip or fan is drawn as separate
// triangles.
void main() {
  const int triangles = kVertices - 2;
  int triangle = gl_VertexID / 3 % triangles, corner = gl_VertexID % 3;
  int number = triangle + corner;
  if (kIsFan) {
    if (corner == 0) number = 0;
  } else if (triangle % 2 == 1 && corner < 2) {
    number = triangle + 1 - corner;  // every other triangle of a strip has the opposite order
  }
  Instance instance = fetch_instance(gl_VertexID / (3 * triangles));
  if (kind_of(instance) == kSolid) {
    set_vertex(place(instance), number);
  } else {
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);  // is clipped
  }
}
