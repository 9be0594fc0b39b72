// A listed surfel as a GL point.
layout(location = 0) uniform float scale;      // factor for the radius
layout(location = 1) uniform float tolerance;  // how far it is pushed back, in scaled radii

flat out vec2 middle;
flat out vec3 conic;
flat out vec3 linear_color;
flat out vec4 depth_plane;  // depth at the middle, its change per pixel (x, y), its largest change

// The least half axes of the disc's image in pixels. The longer one keeps a disc that faces the eye
// from falling between the centres of pixels. The shorter one keeps the conic finite; a larger value
// would widen outlines.
const float kLeastRadius = 0.7;
const float kLeastThickness = 0.05;

void main() {
  Sprite s = fetch_sprite(gl_VertexID);
  vec3 c = scale * scale * s.covariance;
  float half_trace = 0.5 * (c.x + c.z);
  float half_difference = length(vec2(0.5 * (c.x - c.z), c.y));
  // The squares of the half axes.
  float longer = half_trace + half_difference, shorter = half_trace - half_difference;
  c.xz += max(max(kLeastRadius * kLeastRadius - longer, kLeastThickness * kLeastThickness - shorter), 0.0);
  conic = vec3(c.z, -2.0 * c.y, c.x) / (c.x * c.z - c.y * c.y);
  middle = s.middle;
  gl_PointSize = 2.0 * sqrt(max(c.x, c.z));
  // As in surfel_vertex.glsl.
  gl_Position = vec4((2.0 * s.middle / window.xy - 1.0) * s.w,
                     eye.w / (1.0 + tolerance * scale * s.away), s.w);
  depth_plane = gl_Position.z / s.w * vec4(1.0, s.slope, scale * s.away);
  linear_color = vec3(unpackHalf2x16(s.color_rg), unpackHalf2x16(s.color_b).x);
}
