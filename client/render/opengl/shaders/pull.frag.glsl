// A level of means. Each texel is the mean of two by two texels of the next finer level.
layout(binding = 0) uniform sampler2D finer;

layout(location = 0) out vec4 mean;

void main() {
  ivec2 first = 2 * ivec2(gl_FragCoord.xy), size = textureSize(finer, 0);
  vec4 total = vec4(0.0);
  for (int i = 0; i < 4; ++i) {
    ivec2 at = first + ivec2(i & 1, i >> 1);
    if (at.x < size.x && at.y < size.y) total += texelFetch(finer, at, 0);
  }
  mean = 0.25 * total;
}
