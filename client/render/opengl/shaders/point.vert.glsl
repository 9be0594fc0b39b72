// A point as a square, as large as its radius says.
layout(location = 0) uniform float size;     // the least, in pixels
layout(location = 1) uniform float largest;  // in pixels; if it is less than `size`, all have `size`

flat out vec3 linear_color;
flat out float depth, reach;  // point.frag.glsl

void main() {
  Instance point = fetch_instance();
  gl_Position = to_clip * vec4(point.center, 1.0);
  float own = 2.0 * point.radius / (pixel.x * max(gl_Position.w, eye.w));
  gl_PointSize = clamp(own, size, max(size, largest));
  depth = gl_Position.w;
  reach = 0.5 * gl_PointSize * pixel.x * depth;
  vec3 to_eye = towards_eye(point.center);
  bool known = dot(point.normal, point.normal) > 0.25;
  linear_color = lit_color(point.color, known ? oriented(point.normal, to_eye) : to_eye);
}
