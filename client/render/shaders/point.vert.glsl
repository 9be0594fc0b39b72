// A point of fixed size in the picture.
layout(location = 0) in vec4 center_radius;
layout(location = 1) in vec3 normal;  // unit length, or zero where unknown
layout(location = 2) in vec3 color;   // sRGB

layout(location = 0) uniform float size;  // in pixels

flat out vec3 linear_color;

void main() {
  gl_Position = to_clip * vec4(center_radius.xyz, 1.0);
  gl_PointSize = size;
  vec3 to_eye = towards_eye(center_radius.xyz);
  linear_color = shade(color, dot(normal, normal) > 0.25 ? oriented(normal, to_eye) : to_eye);
}
