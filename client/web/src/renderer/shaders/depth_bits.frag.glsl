// Depths as integers, which a page can read.
layout(binding = 0) uniform sampler2D depth;

layout(location = 0) uniform ivec4 first;

layout(location = 0) out uvec4 bits;

void main() {
  bits = uvec4(floatBitsToUint(texelFetch(depth, ivec2(gl_FragCoord.xy) + first.xy, 0).x), 0u, 0u, 0u);
}
