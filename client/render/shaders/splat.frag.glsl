// Second pass of splatting: sums of weighted colours and of weights (ERRATA 10). The weight is the
// paper's round Gaussian mask, section V-B, as a function instead of a texture.
in vec2 mask;
flat in vec3 linear_color;

layout(location = 0) out vec4 sum;

void main() {
  float d2 = dot(mask, mask);
  if (d2 > 1.0) discard;
  float weight = exp(-4.5 * d2);  // the edge is at three standard deviations
  sum = vec4(weight * linear_color, weight);
}
