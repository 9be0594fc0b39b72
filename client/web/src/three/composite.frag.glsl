// Puts a picture of a reel into the scene, each pixel at the depth of its surface.
uniform highp sampler2D color;  // linear, with alpha 1 where something was drawn
uniform highp sampler2D depth;  // the near plane's distance over that of the surface; 0 in filled holes
uniform float near;
uniform mat4 projectionMatrix;
#ifdef USE_LOGARITHMIC_DEPTH_BUFFER
uniform float logDepthBufFC;
#endif
varying vec2 at;

// A filled hole is about as far away as the nearest surface around it.
float depth_around(ivec2 pixel) {
  const int farthest = 32;
  ivec2 last = textureSize(depth, 0) - 1;
  for (int d = 1; d <= farthest; d += (d + 1) / 2) {
    float around = 0.0;
    for (int side = 0; side < 9; ++side) {
      ivec2 there = clamp(pixel + d * (ivec2(side % 3, side / 3) - 1), ivec2(0), last);
      around = max(around, texelFetch(depth, there, 0).r);
    }
    if (around > 0.0) return around;
  }
  return 0.0;
}

void main() {
  // The picture may have fewer pixels than the scene.
  vec2 place = at * vec2(textureSize(color, 0)) - 0.5, share = fract(place);
  ivec2 first = ivec2(floor(place)), last = textureSize(color, 0) - 1, pixel = first;
  vec4 sum = vec4(0.0);
  float most = 0.0;
  for (int i = 0; i < 4; ++i) {
    ivec2 corner = ivec2(i % 2, i / 2), there = clamp(first + corner, ivec2(0), last);
    vec2 shares = mix(1.0 - share, share, vec2(corner));
    vec4 seen = texelFetch(color, there, 0), weighted = shares.x * shares.y * seen.a * vec4(seen.rgb, 1.0);
    sum += weighted;
    if (weighted.a > most) {
      most = weighted.a;
      pixel = there;
    }
  }
  if (sum.a < 0.5) discard;
  float there = texelFetch(depth, pixel, 0).r;
  if (there == 0.0) there = depth_around(pixel);
  if (there == 0.0) discard;
  float away = near / there;
#if defined(USE_LOGARITHMIC_DEPTH_BUFFER)
  gl_FragDepth = 0.5 * logDepthBufFC * log2(1.0 + away);
#else
  float in_picture = projectionMatrix[3][2] / away - projectionMatrix[2][2];
#ifdef USE_REVERSED_DEPTH_BUFFER
  gl_FragDepth = in_picture;
#else
  gl_FragDepth = 0.5 * in_picture + 0.5;
#endif
#endif
  gl_FragColor = vec4(sum.rgb / sum.a, 1.0);
#include <tonemapping_fragment>
#include <colorspace_fragment>
}
