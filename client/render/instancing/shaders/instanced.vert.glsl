// Hardware instancing: a vertex of the template, which follows from its number, of an instance that
// the method fetches.
void main() { set_vertex(place(fetch_instance()), gl_VertexID); }
