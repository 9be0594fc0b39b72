// A colour with the mask as its opacity: Slomp et al., Geometry Instancing, section V-B.
flat in vec3 linear_color;

layout(location = 0) out vec4 color;

void main() {
  float weight = gaussian_mask(footprint());
  if (weight == 0.0) discard;
  color = vec4(linear_color, weight);
}
