// The finest level of means. Each texel covers four by four pixels and takes the mean of four of
// them, no two of which are in the same row or column.
layout(binding = 0) uniform sampler2D sums;

layout(location = 0) out vec4 mean;

void main() {
  const ivec2 kPlaces[4] = ivec2[](ivec2(1, 0), ivec2(3, 1), ivec2(0, 2), ivec2(2, 3));
  ivec2 first = 4 * ivec2(gl_FragCoord.xy), size = textureSize(sums, 0);
  vec4 total = vec4(0.0);
  for (int i = 0; i < 4; ++i) {
    ivec2 at = first + kPlaces[i];
    if (at.x < size.x && at.y < size.y) total += mean_of(texelFetch(sums, at, 0));
  }
  mean = 0.25 * total;
}
