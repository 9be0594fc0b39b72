// A point with a fixed size in the picture.
layout(location = 0) uniform float size;  // in pixels

flat out vec3 linear_color;

void main() {
  Instance point = fetch_instance();
  gl_Position = to_clip * vec4(point.center, 1.0);
  gl_PointSize = size;
  vec3 to_eye = towards_eye(point.center);
  bool known = dot(point.normal, point.normal) > 0.25;
  linear_color = point.color * light_on(known ? oriented(point.normal, to_eye) : to_eye);
}
