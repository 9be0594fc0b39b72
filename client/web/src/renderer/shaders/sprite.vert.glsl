// An instance as a GL point, if a point can cover it. Others are left to solid.vert.glsl.
void main() {
  if (kind_of(fetch_instance()) == kSprite) {
    place_sprite();
  } else {
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);  // is clipped
  }
}
