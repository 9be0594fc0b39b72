// The weighted mean of the splats; in a hole, where there are none but a surface was seen all the
// same (reconstruction.h), what is around it. Elsewhere the background stays.
layout(binding = 0) uniform sampler2D sums;
layout(binding = 1) uniform sampler2D filled;
layout(binding = 2) uniform sampler2D depth;

layout(location = 0) uniform bool fill;

layout(location = 0) out vec4 linear_color;

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec4 mean = mean_of(texelFetch(sums, at, 0));
  if (mean.a == 0.0 && fill && texelFetch(depth, at, 0).x > 0.0) {
    mean = textureLod(filled, 0.5 * gl_FragCoord.xy / vec2(textureSize(filled, 0)), 0.0);
  }
  if (mean.a == 0.0) discard;
  linear_color = vec4(mean.rgb / mean.a, 1.0);
}
