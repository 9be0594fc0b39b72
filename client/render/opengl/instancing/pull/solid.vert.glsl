// A vertex of a listed solid.
layout(std430, binding = 4) readonly buffer Solids { Element solids[]; };

void main() { set_vertex(solids[solid_of(gl_VertexID)], number_in_solid(gl_VertexID)); }
