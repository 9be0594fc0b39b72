// A whole cube as a strip of 14 vertices: the template of Slomp et al., Geometry Instancing, section
// VI-B.
flat out vec3 linear_color;

const int kVertices = 14;
const bool kIsFan = false;

const vec3 kStrip[14] =
    vec3[](vec3(-1, -1, -1), vec3(-1, -1, 1), vec3(-1, 1, -1), vec3(-1, 1, 1), vec3(1, 1, 1),
           vec3(-1, -1, 1), vec3(1, -1, 1), vec3(-1, -1, -1), vec3(1, -1, -1), vec3(-1, 1, -1),
           vec3(1, 1, -1), vec3(1, 1, 1), vec3(1, -1, -1), vec3(1, -1, 1));
// The face of the triangle that ends with each vertex. The last vertex of a triangle gives its
// colour.
const vec3 kFace[14] = vec3[](vec3(0), vec3(0), vec3(-1, 0, 0), vec3(-1, 0, 0), vec3(0, 1, 0),
                              vec3(0, 0, 1), vec3(0, 0, 1), vec3(0, -1, 0), vec3(0, -1, 0),
                              vec3(0, 0, -1), vec3(0, 0, -1), vec3(0, 1, 0), vec3(1, 0, 0),
                              vec3(1, 0, 0));

void set_vertex(Element e, int number) {
  gl_Position = corner_position(e, kStrip[number]);
  linear_color = face_color(e, kFace[number]);
}
