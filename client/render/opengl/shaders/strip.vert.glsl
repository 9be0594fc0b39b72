// A vertex of a triangle strip, as it is.
out vec3 linear_color;
out vec3 normal_there;
out vec3 from_eye;

void main() {
  Instance vertex = fetch_instance();
  gl_Position = to_clip * vec4(vertex.center, 1.0);
  linear_color = vertex.color;
  from_eye = vertex.center - eye.xyz;
  normal_there = oriented(vertex.normal, -from_eye);
}
