// Shared by both ways to draw a voxel: voxel_cube.glsl and voxel_faces.glsl.
struct Element {
  vec4 center;   // clip coordinates
  vec3 octant;   // in which the eye lies as seen from the centre; each component is -1 or 1
  float half_edge;
  vec3 normal;   // used for lighting; zero if unknown
  vec3 color;    // linear
};

Element place(Instance voxel) {
  vec4 center = to_clip * vec4(voxel.center, 1.0);
  // No cube is drawn smaller than a pixel, so that none falls between the centres of pixels.
  float half_edge = max(voxel.radius, 0.5 * pixel.x * center.w);
  vec3 n = oriented(voxel.normal, towards_eye(voxel.center));
  return Element(center, mix(vec3(-1.0), vec3(1.0), greaterThanEqual(eye.xyz, voxel.center)),
                 half_edge, dot(n, n) < 0.25 ? vec3(0.0) : n, voxel.color);
}

vec4 corner_position(Element e, vec3 corner) {
  return e.center + to_clip * vec4(e.half_edge * corner, 0.0);
}

// The colour of a face. If the normal of the voxel is unknown, that of the face is used for lighting.
vec3 face_color(Element e, vec3 face) {
  return lit_color(e.color, e.normal == vec3(0.0) ? face : e.normal);
}
