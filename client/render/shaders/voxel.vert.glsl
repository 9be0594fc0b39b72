// The three faces of a cube that the eye can see, as a fan of eight vertices around the corner
// nearest to the eye: paper 2, section VI-B, without the faces that are hidden anyway.
layout(location = 0) in vec4 center_half;
layout(location = 1) in vec3 normal;  // mean of the voxel, unit length, or zero where unknown
layout(location = 2) in vec3 color;   // sRGB

flat out vec3 linear_color;

// The nearest corner and the six around it, for an eye in the octant of positive coordinates. Seen
// from outside they turn anticlockwise; two triangles to a face, x, y and z.
const vec3 kFan[8] = vec3[](vec3(1, 1, 1), vec3(1, -1, 1), vec3(1, -1, -1), vec3(1, 1, -1),
                            vec3(-1, 1, -1), vec3(-1, 1, 1), vec3(-1, -1, 1), vec3(1, -1, 1));

void main() {
  vec3 center = center_half.xyz;
  vec3 octant = mix(vec3(-1.0), vec3(1.0), greaterThanEqual(eye.xyz, center));
  // Mirroring turns the fan round: walk it backwards to keep the outside in front.
  bool mirrored = octant.x * octant.y * octant.z < 0.0;
  int vertex = mirrored && gl_VertexID > 0 ? 8 - gl_VertexID : gl_VertexID;
  // Never smaller than a pixel: a cube that falls between the pixels' centres would not be seen.
  float depth = (to_clip * vec4(center, 1.0)).w;
  float half_edge = max(center_half.w, 0.5 * pixel.x * depth);
  gl_Position = to_clip * vec4(center + half_edge * octant * kFan[vertex], 1.0);

  // The last vertex of a triangle gives its colour.
  vec3 n = oriented(normal, towards_eye(center));
  if (dot(n, n) < 0.25) {
    int face = (mirrored ? 7 - gl_VertexID : gl_VertexID - 2) / 2;
    n = vec3(0.0);
    if (gl_VertexID >= 2) n[face] = octant[face];
  }
  linear_color = shade(color, n);
}
