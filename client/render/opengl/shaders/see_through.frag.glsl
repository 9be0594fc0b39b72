// Clears the sums of pixels that show a farther surface through a hole of a nearer one
// (reconstruction.h), so that they are filled like any other hole.
layout(binding = 0) uniform sampler2D depth;  // reversed: 0 is infinitely far

layout(location = 0) uniform float radius;   // of a typical surfel
layout(location = 1) uniform float nearest;  // depth of the nearest surfels, or less

layout(location = 0) out vec4 sum;

// How far a hole reaches from one of its pixels to its rim at most, in radii.
const float kReach = 5.0;
// In how many distances, for each direction, the rim is looked for.
const int kDistances = 8;
// How much nearer the rim is at least, in radii. More than twice the depth tolerance of splats.
const float kNearer = 4.0;

// The farthest that the rim of a hole can be in the picture, in pixels, if the rim has this depth.
float reach_at(float w) { return max(kReach * radius / (pixel.x * w), 2.0); }

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy), size = textureSize(depth, 0);
  float own = texelFetch(depth, at, 0).x;
  if (own == 0.0) discard;
  // The depth that the rim has at most. The nearer it is, the larger its surfels look.
  float most = eye.w / own - kNearer * radius;
  if (most <= nearest) discard;
  float least_steps = max(0.25 * reach_at(most), 1.0);
  float most_steps = clamp(reach_at(nearest), least_steps, max(least_steps, 0.5 * window.y));
  float factor = pow(most_steps / least_steps, 1.0 / float(kDistances - 1));
  const ivec2 kAround[8] = ivec2[](ivec2(1, 0), ivec2(-1, 0), ivec2(0, 1), ivec2(0, -1),
                                   ivec2(1, 1), ivec2(-1, -1), ivec2(-1, 1), ivec2(1, -1));
  // Most pixels are not in a hole, which the first direction tells.
  for (int i = 0; i < 8; ++i) {
    bool rim = false;
    float away = least_steps;
    for (int k = 0; k < kDistances && !rim; ++k, away *= factor) {
      ivec2 there = at + int(away + 0.5) * kAround[i];
      // The edge of the picture may cut a hole.
      if (any(lessThan(there, ivec2(0))) || any(greaterThanEqual(there, size))) {
        rim = true;
      } else {
        float w = eye.w / max(texelFetch(depth, there, 0).x, 1e-30);
        rim = w < most && away <= reach_at(w);
      }
    }
    if (!rim) discard;
  }
  sum = vec4(0.0);
}
