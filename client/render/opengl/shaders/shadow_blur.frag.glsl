// Blurs the nearest to the light, and its square, along rows or columns.
layout(binding = 0) uniform sampler2D map;

layout(location = 0) uniform ivec2 along;
layout(location = 1) uniform bool nearest;  // the map has only the nearest, not its square

layout(location = 0) out vec4 moments;

vec2 at(int i) {
  ivec2 last = textureSize(map, 0) - 1;
  vec2 there = texelFetch(map, clamp(ivec2(gl_FragCoord.xy) + i * along, ivec2(0), last), 0).xy;
  return nearest ? vec2(there.x, there.x * there.x) : there;
}

void main() {
  const float kBlur[4] = float[](0.2, 0.18, 0.14, 0.08);
  vec2 sum = kBlur[0] * at(0);
  for (int i = 1; i < 4; ++i) sum += kBlur[i] * (at(-i) + at(i));
  moments = vec4(sum, 0.0, 1.0);
}
