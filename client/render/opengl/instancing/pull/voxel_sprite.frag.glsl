// Intersects the ray through the centre of the pixel with a cube. The ray enters at the last of the
// three planes on the side of the eye, unless it has left through one of the other three before.
flat in vec3 center;
flat in float half_edge;
flat in vec3 face_light;
flat in vec3 linear_color;

layout(location = 0) out vec4 color;

void main() {
  vec3 inverse = 1.0 / pixel_ray(gl_FragCoord.xy);
  vec3 middle = center * inverse, reach = abs(half_edge * inverse);
  vec3 enter = middle - reach, leave = middle + reach;
  float depth = max(max(enter.x, enter.y), enter.z);
  if (!(depth <= min(min(leave.x, leave.y), leave.z))) discard;
  float on_face = enter.x == depth ? face_light.x : enter.y == depth ? face_light.y : face_light.z;
  color = vec4(on_face * linear_color, 1.0);
  if (face_light.x < 0.0) {
    vec3 face = vec3(enter.x == depth, enter.x != depth && enter.y == depth,
                     enter.x != depth && enter.y != depth);
    color.rgb = 0.5 - 0.5 * face * mix(vec3(-1.0), vec3(1.0), greaterThanEqual(center, vec3(0.0)));
  }
  gl_FragDepth = eye.w / depth;
}
