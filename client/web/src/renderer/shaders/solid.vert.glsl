// A vertex of an instance that is too large for a GL point.
void main() {
  Instance instance = fetch_instance(solid_of(gl_VertexID));
  if (kind_of(instance) == kSolid) {
    set_vertex(place(instance), number_in_solid(gl_VertexID));
  } else {
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);  // is clipped
  }
}
