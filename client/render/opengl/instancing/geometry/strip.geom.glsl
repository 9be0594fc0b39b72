// Expands a point into a triangle strip.
layout(points) in;
layout(triangle_strip, max_vertices = kVertices) out;

in Instance forwarded[];

void main() {
  Element e = place(forwarded[0]);
  for (int i = 0; i < kVertices; ++i) {
    set_vertex(e, i);
    EmitVertex();
  }
}
