// Pixels at the outline of what was drawn get the share of its colour that it covers (outlines.h).
layout(binding = 0) uniform sampler2D picture;

layout(location = 0) uniform ivec4 region;  // of the picture: its first and its last pixel

layout(location = 0) out vec4 color;

const int kReach = 2;

vec4 at(ivec2 pixel) { return texelFetch(picture, clamp(pixel, region.xy, region.zw), 0); }

bool is_drawn(vec4 there) { return there.a > 0.99; }

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec4 own = at(pixel);
  bool drawn = is_drawn(own);
  // Only pixels beside an outline change.
  const ivec2 beside[8] = ivec2[](ivec2(1, 0), ivec2(0, 1), ivec2(-1, 0), ivec2(0, -1),
                                  ivec2(1, 1), ivec2(-1, 1), ivec2(-1, -1), ivec2(1, -1));
  vec3 surface = vec3(0.0), background = vec3(0.0);
  int surfaces = 0, backgrounds = 0;
  for (int i = 0; i < 8; ++i) {
    vec4 there = at(pixel + beside[i]);
    if (is_drawn(there)) {
      surface += there.rgb;
      ++surfaces;
    } else {
      background += there.rgb;
      ++backgrounds;
    }
  }
  if ((drawn ? backgrounds : surfaces) == 0) discard;
  int covered = 0;
  for (int y = -kReach; y <= kReach; ++y)
    for (int x = -kReach; x <= kReach; ++x) covered += is_drawn(at(pixel + ivec2(x, y))) ? 1 : 0;
  // A straight outline at the distance d from the pixel's middle covers 1/2 + d / edge of a square
  // around it, and 1/2 + d of the pixel. Thin parts cover little of the square, and must stay.
  const float edge = float(2 * kReach + 1);
  float share = 0.5 + edge * (float(covered) / (edge * edge) - 0.5);
  share = drawn ? clamp(share, 0.5, 1.0) : clamp(share, 0.0, 0.5);
  if (drawn) {
    surface = own.rgb;
    background /= float(backgrounds);
  } else {
    surface /= float(surfaces);
    background = own.rgb;
  }
  color = vec4(mix(background, surface, share), 1.0);
}
