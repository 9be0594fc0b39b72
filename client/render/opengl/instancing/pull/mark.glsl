// Used by the first step to decide whether an instance is visible, and how it is drawn.
const uint kHidden = 0u, kSprite = 1u, kSolid = 2u;

layout(location = 3) uniform float largest_scale;

// The largest sprite, in pixels. For larger instances, the tighter outline of triangles pays off.
const float kLargestSprite = 48.0;
// The largest radius of a sprite, as a share of its distance from the eye. The projection of sprites
// is approximated as affine.
const float kNearestSprite = 0.015;

// How fast clip coordinates change with the distance from the plane of a side of the picture.
float side_length(int axis) { return length(clip_row(3) + clip_row(axis)); }

// GL points are drawn only if their middle is in the picture. Instances that reach into it from
// outside are therefore solids.
uint kind_of(vec3 center, float radius) {
  vec4 c = to_clip * vec4(center, 1.0);
  vec2 outside = abs(c.xy) - c.w;
  // The square around the image of the sphere has the edge 2 radius distance / (w^2 pixel).
  vec3 from_eye = center - eye.xyz;
  float reach = 2.0 * radius, most = kLargestSprite * pixel.x * c.w * c.w;
  if (c.w >= eye.w && max(outside.x, outside.y) <= 0.0 && radius <= kNearestSprite * c.w &&
      reach * reach * dot(from_eye, from_eye) <= most * most) {
    return kSprite;
  }
  bool in_view = c.w + radius >= eye.w && outside.x <= radius * side_length(0) &&
                 outside.y <= radius * side_length(1);
  return in_view ? kSolid : kHidden;
}
