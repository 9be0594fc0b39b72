// A point becomes three faces, each a strip of four vertices: there are no fans here. The fan of
// voxel_faces.glsl has two triangles to a face, which are numbers 0 a b and 0 b c of its vertices.
layout(points) in;
layout(triangle_strip, max_vertices = 12) out;

in Instance forwarded[];

void main() {
  Element e = place(forwarded[0]);
  for (int face = 0; face < 3; ++face) {
    int a = 2 * face + 1;
    set_vertex(e, a + 1);
    vec3 color = linear_color;
    const int strip[4] = int[](0, 1, -1, 2);  // from a on; -1: vertex 0
    for (int i = 0; i < 4; ++i) {
      set_vertex(e, i == 2 ? 0 : a + strip[i]);
      linear_color = color;
      EmitVertex();
    }
    EndPrimitive();
  }
}
