// Draws the back of a surfel as a square that faces the eye, for its depth. Surfels whose front is
// visible are left out.
layout(location = 0) uniform float reach;      // half the edge of the square, in radii
layout(location = 1) uniform float tolerance;  // how far it is moved away from the eye, in radii
layout(location = 2) uniform uint one_in;      // one in this many surfels is drawn

// A pseudo-random number that depends only on the position.
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
  // A surfel that is seen at an angle gets a square as narrow as it looks, to keep outlines in place.
  gl_PointSize = clamp(2.0 * reach * surfel.radius * away / (pixel.x * max(gl_Position.w, eye.w)),
                       1.0, 1024.0);
  gl_Position.z /= 1.0 + tolerance * surfel.radius / max(distance(eye.xyz, surfel.center), eye.w);
  if (!(away > 0.0) || hash(surfel.center) % one_in != 0u) gl_Position = vec4(0.0, 0.0, -1.0, 1.0);  // is clipped
}
