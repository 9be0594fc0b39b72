// Adds weighted colours and weights. FORMULAS.md, "Order-independent blending".
flat in vec3 linear_color;

layout(location = 0) out vec4 sum;

void main() {
  float weight = gaussian_mask(footprint());
  if (weight == 0.0) discard;
  sum = vec4(weight * linear_color, weight);
}
