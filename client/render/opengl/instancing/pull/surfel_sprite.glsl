// A surfel as a GL point that covers its disc: one vertex instead of four, one square instead of two
// triangles. The fragment shader decides which pixels belong to the disc (sprite_footprint.glsl).
// The disc is small in the picture, so its projection is approximated as affine.
struct Sprite {
  vec2 middle;      // window coordinates
  float w;          // of the clip coordinates, which is the depth in front of the eye
  float away;       // radius divided by the distance from the eye
  vec3 covariance;  // xx, xy, yy in square pixels: the image of the disc is d' C^-1 d <= 1
  uint color_rg;    // linear, half floats
  vec2 slope;       // relative change of 1 / depth per pixel
  uint color_b;
  uint unused;
};

// J (1 - n n') J' r^2, where J is the Jacobian of the window coordinates.
vec3 covariance(vec3 from_eye, vec3 n, float radius, float w) {
  vec3 x, y;
  window_slopes(from_eye, w, x, y);
  float nx = dot(n, x), ny = dot(n, y);
  return radius * radius * vec3(dot(x, x) - nx * nx, dot(x, y) - nx * ny, dot(y, y) - ny * ny);
}

Sprite make_sprite(Instance surfel) {
  vec3 n = surfel_normal(surfel, towards_eye(surfel.center));
  vec3 from_eye = surfel.center - eye.xyz;
  vec4 clip = to_clip * vec4(surfel.center, 1.0);
  vec3 color = lit_color(surfel.color, n);
  // On a plane, 1 / depth is linear in the picture: (n . ray) / (n . center).
  float facing = dot(n, from_eye);
  vec2 slope = vec2(dot(n, ray_x.xyz), dot(n, ray_y.xyz)) * (clip.w / min(facing, -1e-30));
  return Sprite(0.5 * window.xy * (clip.xy / clip.w + 1.0), clip.w,
                surfel.radius / max(length(from_eye), eye.w),
                covariance(from_eye, n, surfel.radius, clip.w), packHalf2x16(color.rg), slope,
                packHalf2x16(vec2(color.b, 0.0)), 0u);
}
