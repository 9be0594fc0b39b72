// The mean colours of a level; where it has none, those of the next coarser level. They are multiplied
// by the largest share that is covered of any square around (a), of this level or a coarser one.
layout(binding = 0) uniform sampler2D own;
layout(binding = 1) uniform sampler2D coarser;

layout(location = 0) out vec4 filled;

void main() {
  vec4 mean = texelFetch(own, ivec2(gl_FragCoord.xy), 0);
  filled = textureLod(coarser, 0.5 * gl_FragCoord.xy / vec2(textureSize(coarser, 0)), 0.0);
  if (mean.a > 0.0) filled = max(1.0, filled.a / mean.a) * mean;
}
