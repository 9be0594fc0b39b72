// A voxel as a GL point that covers its cube: one vertex instead of eight, one square instead of six
// triangles. The fragment shader decides which face a pixel shows (voxel_sprite.frag.glsl).
struct Sprite {
  vec3 center;  // relative to the eye
  float half_edge;
  vec3 light;   // on the visible face across each axis; < 0 to draw the normals of faces
  float size;   // in pixels
  vec3 color;   // linear
  float unused;
};

float depth_of(Instance voxel) { return (to_clip * vec4(voxel.center, 1.0)).w; }

// No cube is drawn smaller than a pixel, as in voxel.glsl.
float drawn_half_edge(Instance voxel) {
  return max(voxel.radius, 0.5 * pixel.x * depth_of(voxel));
}

// Edge in pixels of the square around the image of the cube. It is that of the affine projection at
// the centre, enlarged because the nearest corner may be nearer to the eye.
float sprite_size(Instance voxel) {
  float w = depth_of(voxel), edge = drawn_half_edge(voxel);
  vec3 x, y;
  window_slopes(voxel.center - eye.xyz, w, x, y);
  vec2 size = 2.0 * edge * vec2(dot(abs(x), vec3(1.0)), dot(abs(y), vec3(1.0)));
  return max(size.x, size.y) * w / max(w - 1.73206 * edge, 1e-30);
}

Sprite make_sprite(Instance voxel) {
  Element e = place(voxel);
  vec3 x = vec3(e.octant.x, 0.0, 0.0), y = vec3(0.0, e.octant.y, 0.0), z = vec3(0.0, 0.0, e.octant.z);
  bool known = e.sides == 0.0;
  if (light.w > 1.5)
    return Sprite(voxel.center - eye.xyz, e.half_edge, vec3(known ? 1.0 : -1.0), sprite_size(voxel),
                  0.5 + 0.5 * e.normal, 0.0);
  return Sprite(voxel.center - eye.xyz, e.half_edge,
                vec3(light_on(lit_normal(e, x)), light_on(lit_normal(e, y)), light_on(lit_normal(e, z))),
                sprite_size(voxel), e.color, 0.0);
}
