// Expands a point into three faces. Geometry shaders have no fans, so each face is a strip of four
// vertices. In the fan of voxel_faces.glsl, a face consists of the two triangles with the vertices
// (0, a, b) and (0, b, c).
layout(points) in;
layout(triangle_strip, max_vertices = 12) out;

in Instance forwarded[];

void main() {
  Element e = place(forwarded[0]);
  for (int face = 0; face < 3; ++face) {
    int a = 2 * face + 1;
    set_vertex(e, a + 1);
    vec3 color = linear_color;
    const int strip[4] = int[](0, 1, -1, 2);  // offsets from a; -1 stands for vertex 0
    for (int i = 0; i < 4; ++i) {
      set_vertex(e, i == 2 ? 0 : a + strip[i]);
      linear_color = color;
      EmitVertex();
    }
    EndPrimitive();
  }
}
