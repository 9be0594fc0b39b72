// The share of its light that a pixel keeps (eye_dome_lighting.h).
layout(binding = 0) uniform sampler2D depth;
layout(binding = 1) uniform sampler2D sums;

layout(location = 0) uniform float strength;
layout(location = 1) uniform bool splatted;  // pixels without `sums` were filled

layout(location = 0) out vec4 factor;

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy), last = textureSize(depth, 0) - 1;
  float own = texelFetch(depth, at, 0).x;  // reversed: 0 is infinitely far
  if (own == 0.0 || splatted && texelFetch(sums, at, 0).a == 0.0) discard;
  // A few pixels in large pictures, so that the fine grain of depths does not show.
  int reach = max(1, int(window.y / 720.0 + 0.5));
  float behind = 0.0;
  for (int i = 0; i < 8; ++i) {
    const ivec2 around[8] = ivec2[](ivec2(1, 0), ivec2(1, 1), ivec2(0, 1), ivec2(-1, 1),
                                    ivec2(-1, 0), ivec2(-1, -1), ivec2(0, -1), ivec2(1, -1));
    float other = texelFetch(depth, clamp(at + reach * around[i], ivec2(0), last), 0).x;
    // The logarithm of the ratio of the distances. Pixels that show nothing do not count.
    if (other > 0.0) behind += min(max(log2(other / own), 0.0), 0.1);
  }
  factor = vec4(exp(-8.0 * strength * behind));
}
