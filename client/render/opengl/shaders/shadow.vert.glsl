// An instance as a square in the map of the key light.
void main() {
  Instance one = fetch_instance();
  vec3 at = (to_shadow * vec4(one.center, 1.0)).xyz;
  gl_Position = vec4(2.0 * at.xy - 1.0, at.z, 1.0);
  const float edge = 256.0;
  gl_PointSize =
      max(1.0, 2.0 * edge * one.radius * length(vec3(to_shadow[0].x, to_shadow[1].x, to_shadow[2].x)));
}
