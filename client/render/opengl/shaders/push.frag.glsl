// The mean colours of a level; where it has none, those of the next coarser level.
layout(binding = 0) uniform sampler2D own;
layout(binding = 1) uniform sampler2D coarser;

layout(location = 0) out vec4 filled;

void main() {
  filled = texelFetch(own, ivec2(gl_FragCoord.xy), 0);
  if (filled.a == 0.0) {
    filled = textureLod(coarser, 0.5 * gl_FragCoord.xy / vec2(textureSize(coarser, 0)), 0.0);
  }
  if (filled.a > 0.0) filled /= filled.a;
}
