// A vertex of an element that was listed.
layout(std430, binding = 3) readonly buffer Elements { Element elements[]; };

void main() { set_vertex(elements[gl_VertexID / kVertices], gl_VertexID % kVertices); }
