// Hardware instancing: a vertex of the template, by its number, for the instance that
// `fetch_instance` returns.
void main() { set_vertex(place(fetch_instance()), gl_VertexID); }
