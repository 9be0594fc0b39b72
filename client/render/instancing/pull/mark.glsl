// For the first step: what decides whether an instance can be seen.
layout(location = 3) uniform float largest_scale;

// Distances from the planes of the picture's sides grow by so much a unit of clip coordinates.
float side_length(int axis) {
  vec3 w = vec3(to_clip[0].w, to_clip[1].w, to_clip[2].w);
  return length(w + vec3(to_clip[0][axis], to_clip[1][axis], to_clip[2][axis]));
}

// Whether any of a sphere may be in front of the near plane and within the four sides.
bool sphere_in_view(vec3 center, float radius) {
  vec4 c = to_clip * vec4(center, 1.0);
  return c.w + radius >= eye.w && abs(c.x) <= c.w + radius * side_length(0) &&
         abs(c.y) <= c.w + radius * side_length(1);
}
