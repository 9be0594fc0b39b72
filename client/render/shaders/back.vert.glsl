// The back of a surfel, for its depth: a square that faces the eye. Fronts are left out.
layout(location = 0) uniform float reach;      // half the square's edge, in radii
layout(location = 1) uniform float tolerance;  // moves it away from the eye, in radii
layout(location = 2) uniform uint one_in;      // so many surfels, one is drawn

// Any number, as good as random, that only the place decides.
uint hash(vec3 place) {
  uvec3 bits = floatBitsToUint(place);
  uint h = bits.x * 0x9e3779b1u ^ bits.y * 0x85ebca77u ^ bits.z * 0xc2b2ae3du;
  h = (h ^ h >> 15) * 0x2c1b3c6du;
  h = (h ^ h >> 12) * 0x297a2d39u;
  return h ^ h >> 15;
}

void main() {
  Instance surfel = fetch_instance();
  vec3 to_eye = towards_eye(surfel.center);
  float away = -dot(oriented(surfel.normal, to_eye), to_eye);
  gl_Position = to_clip * vec4(surfel.center, 1.0);
  // Where the surfel is seen at an angle, as narrow as it looks, so that outlines stay as they are.
  gl_PointSize = clamp(2.0 * reach * surfel.radius * away / (pixel.x * max(gl_Position.w, eye.w)),
                       1.0, 1024.0);
  gl_Position.z /= 1.0 + tolerance * surfel.radius / max(distance(eye.xyz, surfel.center), eye.w);
  if (!(away > 0.0) || hash(surfel.center) % one_in != 0u) gl_Position = vec4(0.0, 0.0, -1.0, 1.0);  // clipped
}
