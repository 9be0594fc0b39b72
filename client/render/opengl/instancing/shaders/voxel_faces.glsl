// The three faces of a cube that the eye can see, as a fan of eight vertices around the corner
// nearest to the eye. FORMULAS.md, "Visible faces".
flat out vec3 linear_color;

const int kVertices = 8;
const bool kIsFan = true;

// The nearest corner and the six around it, for an eye in the octant of positive coordinates. Seen
// from outside they run anticlockwise. Each face has two triangles; the faces are x, y and z.
const vec3 kFan[8] = vec3[](vec3(1, 1, 1), vec3(1, -1, 1), vec3(1, -1, -1), vec3(1, 1, -1),
                            vec3(-1, 1, -1), vec3(-1, 1, 1), vec3(-1, -1, 1), vec3(1, -1, 1));

// The last vertex of a triangle gives its colour.
void set_vertex(Element e, int number) {
  // Mirroring reverses the fan, so it is walked backwards to keep front faces in front.
  bool mirrored = e.octant.x * e.octant.y * e.octant.z < 0.0;
  gl_Position = corner_position(e, e.octant * kFan[mirrored ? (8 - number) & 7 : number]);
  vec3 face = vec3(0.0);
  if (number >= 2) {
    int axis = (mirrored ? 7 - number : number - 2) / 2;
    face[axis] = e.octant[axis];
  }
  linear_color = face_color(e, face);
}
