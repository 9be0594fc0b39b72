// A point. Its depth falls off from the middle, so that where squares overlap, each pixel shows the
// point that is closest to it, and not the one that is a little nearer to the eye.
flat in vec3 linear_color;
flat in float depth;  // of the middle
flat in float reach;  // half the edge of the square

layout(location = 0) out vec4 color;

void main() {
  vec2 off = 2.0 * gl_PointCoord - 1.0;
  color = vec4(linear_color, 1.0);
  gl_FragDepth = eye.w / (depth + reach * dot(off, off));
}
