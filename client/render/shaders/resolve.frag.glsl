// The weighted mean. Where hardly anything was summed up there is a hole,
// and the background stays.
layout(binding = 0) uniform sampler2D sums;

layout(location = 0) out vec4 linear_color;

void main() {
  const float hole = 0.02;
  vec4 sum = texelFetch(sums, ivec2(gl_FragCoord.xy), 0);
  if (!(sum.w >= hole)) discard;
  linear_color = vec4(sum.rgb / sum.w, 1.0);
}
