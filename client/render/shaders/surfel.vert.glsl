// A surfel as an oriented quad: paper 2, section V-A, with ERRATA 1 to 3. One instance a surfel;
// the four vertices of the template, a triangle strip, follow from gl_VertexID.
layout(location = 0) in vec4 center_radius;
layout(location = 1) in vec3 normal;  // unit length, or zero where unknown
layout(location = 2) in vec3 color;   // sRGB

layout(location = 0) uniform float scale;      // of the splat's radius
layout(location = 1) uniform float tolerance;  // pushes the quad back, in scaled radii

out vec2 mask;  // -1 to 1 across the quad
flat out vec3 linear_color;

// The same as surfel_frame.h.
void surfel_frame(vec3 n, out vec3 u, out vec3 v) {
  bool at_pole = n.x * n.x + n.z * n.z < 1e-12;
  vec3 a = at_pole ? vec3(0.0, 0.0, -1.0) : vec3(0.0, 1.0, 0.0);
  u = normalize(cross(a, n));
  v = cross(n, u);
}

void main() {
  vec3 center = center_radius.xyz;
  vec3 to_eye = towards_eye(center);
  bool known = dot(normal, normal) > 0.25;
  // Back-face culling before there is a face; a surfel of unknown orientation has no back.
  vec3 n = oriented(normal, to_eye);
  if (known && dot(n, to_eye) <= 0.0) {
    gl_Position = kCulled;
    mask = vec2(0.0);
    linear_color = vec3(0.0);
    return;
  }
  n = known ? normalize(n) : to_eye;
  vec3 u, v;
  surfel_frame(n, u, v);
  mask = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
  float radius = center_radius.w * scale;
  gl_Position = to_clip * vec4(center + radius * (mask.x * u + mask.y * v), 1.0);
  // Moving a point away from the eye by a factor divides its reversed depth by that factor and
  // changes nothing else, so the quad keeps its place in the picture (ERRATA 9).
  gl_Position.z /= 1.0 + tolerance * radius / max(distance(eye.xyz, center), eye.w);
  linear_color = shade(color, n);
}
