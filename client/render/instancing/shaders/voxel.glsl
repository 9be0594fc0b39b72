// What both ways to draw a voxel have in common: voxel_cube.glsl, voxel_faces.glsl.
struct Element {
  vec4 center;   // clip coordinates
  vec3 octant;   // of the eye as seen from the centre: -1 or 1 each
  float half_edge;
  vec3 normal;   // as it is lit; zero where unknown
  vec3 color;    // linear
};

Element place(Instance voxel) {
  vec4 center = to_clip * vec4(voxel.center, 1.0);
  // Never smaller than a pixel: a cube that falls between the pixels' centres would not be seen.
  float half_edge = max(voxel.radius, 0.5 * pixel.x * center.w);
  vec3 n = oriented(voxel.normal, towards_eye(voxel.center));
  return Element(center, mix(vec3(-1.0), vec3(1.0), greaterThanEqual(eye.xyz, voxel.center)),
                 half_edge, dot(n, n) < 0.25 ? vec3(0.0) : n, voxel.color);
}

vec4 corner_position(Element e, vec3 corner) {
  return e.center + to_clip * vec4(e.half_edge * corner, 0.0);
}

// The colour of one side, which lights the voxel where its own normal is unknown.
vec3 face_color(Element e, vec3 face) {
  return e.color * light_on(e.normal == vec3(0.0) ? face : e.normal);
}
