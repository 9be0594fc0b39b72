// Shared by both ways to draw a voxel: voxel_cube.glsl and voxel_faces.glsl.
struct Element {
  vec4 center;   // clip coordinates
  vec3 octant;   // in which the eye lies as seen from the centre; each component is -1 or 1
  float half_edge;
  vec3 normal;   // used for lighting; that towards the eye if it is unknown
  float sides;   // how far the normals of faces take its place
  vec3 color;    // linear
};

Element place(Instance voxel) {
  vec4 center = to_clip * vec4(voxel.center, 1.0);
  // No cube is drawn smaller than a pixel, so that none falls between the centres of pixels.
  float half_edge = max(voxel.radius, 0.5 * pixel.x * center.w);
  vec3 to_eye = towards_eye(voxel.center), n = oriented(voxel.normal, to_eye);
  bool known = dot(n, n) >= 0.25;
  // A face of few pixels shows no shape yet: it would be a dark speck.
  float edge = 2.0 * half_edge / (pixel.x * max(center.w, eye.w));
  float sides = known ? 0.0 : light.w > 1.5 ? 1.0 : smoothstep(2.0, 8.0, edge);
  return Element(center, mix(vec3(-1.0), vec3(1.0), greaterThanEqual(eye.xyz, voxel.center)),
                 half_edge, known ? n : to_eye, sides, voxel.color);
}

vec4 corner_position(Element e, vec3 corner) {
  return e.center + to_clip * vec4(e.half_edge * corner, 0.0);
}

// What lights a face.
vec3 lit_normal(Element e, vec3 face) { return mix(e.normal, face, e.sides); }

vec3 face_color(Element e, vec3 face) { return lit_color(e.color, lit_normal(e, face)); }
