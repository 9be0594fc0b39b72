// A vertex of a solid that was listed.
layout(std430, binding = 4) readonly buffer Solids { Element solids[]; };

void main() { set_vertex(solids[gl_VertexID / kVertices], gl_VertexID % kVertices); }
