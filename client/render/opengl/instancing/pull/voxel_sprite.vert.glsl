// A listed voxel as a GL point.
flat out vec3 center;  // relative to the eye
flat out float half_edge;
flat out vec3 face_light;
flat out vec3 linear_color;

void main() {
  Sprite s = fetch_sprite(gl_VertexID);
  gl_Position = to_clip * vec4(s.center + eye.xyz, 1.0);
  gl_PointSize = s.size + 1.0;
  center = s.center;
  half_edge = s.half_edge;
  face_light = s.light;
  linear_color = s.color;
}
