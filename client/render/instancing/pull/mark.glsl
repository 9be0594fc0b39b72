// For the first step: what decides whether an instance can be seen, and how it is drawn.
const uint kHidden = 0u, kSprite = 1u, kSolid = 2u;

layout(location = 3) uniform float largest_scale;

// Sides of points in pixels. Above, the tighter outline of triangles is worth their number.
const float kLargestSprite = 48.0;
// And in distances from the eye, for what takes the projection as affine.
const float kNearestSprite = 0.015;

// Distances from the planes of the picture's sides grow by so much a unit of clip coordinates.
float side_length(int axis) { return length(clip_row(3) + clip_row(axis)); }

// Points are drawn where their middle is in the picture; so what only reaches into it is a solid.
uint kind_of(vec3 center, float radius) {
  vec4 c = to_clip * vec4(center, 1.0);
  vec2 outside = abs(c.xy) - c.w;
  // A square around the sphere's image has the side 2 radius distance / (w^2 pixel).
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
