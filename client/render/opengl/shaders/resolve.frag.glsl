// The weighted mean of the splats, and in holes of the surface the colours around them
// (reconstruction.h). Elsewhere the background stays.
layout(binding = 0) uniform sampler2D sums;
layout(binding = 1) uniform sampler2D filled;
layout(binding = 2) uniform sampler2D depth;
layout(binding = 3) uniform sampler2D crowd;

layout(location = 0) uniform bool fill;
layout(location = 1) uniform float crowd_edge;  // edge of a texel of `crowd`, in pixels

layout(location = 0) out vec4 linear_color;

bool seen(vec2 at) {
  ivec2 pixel = clamp(ivec2(at), ivec2(0), textureSize(depth, 0) - 1);
  return texelFetch(depth, pixel, 0).x > 0.0;
}

// A pixel is a hole if it shows the inside of a surface, if all its neighbours show a surface, or if
// most of the area around it is covered. At the outline of a surface no more than half of it is.
// Near the border of the picture, the area around a pixel is not known.
bool is_hole() {
  const float most = 0.7;
  vec2 at = gl_FragCoord.xy;
  if (seen(at)) return true;
  vec3 d = 0.5 * crowd_edge * vec3(1.0, -1.0, 0.0);
  if (seen(at + d.xx) && seen(at + d.xy) && seen(at + d.yx) && seen(at + d.yy) &&
      seen(at + d.xz) && seen(at + d.yz) && seen(at + d.zx) && seen(at + d.zy)) {
    return true;
  }
  vec2 border = min(at, vec2(textureSize(depth, 0)) - at);
  if (min(border.x, border.y) < crowd_edge) return false;
  return textureLod(crowd, at / crowd_edge / vec2(textureSize(crowd, 0)), 0.0).a >= most;
}

void main() {
  vec4 mean = mean_of(texelFetch(sums, ivec2(gl_FragCoord.xy), 0));
  if (mean.a == 0.0 && fill && is_hole()) {
    // A side that is open has no surface around it that it could be a hole of.
    const float least = 0.3;
    vec4 around = textureLod(filled, 0.25 * gl_FragCoord.xy / vec2(textureSize(filled, 0)), 0.0);
    if (around.a >= least) mean = around;
  }
  if (mean.a == 0.0) discard;
  linear_color = vec4(mean.rgb / mean.a, 1.0);
}
