// What every stage sees. Coordinates of the scene are relative to the origin of its instances.
layout(std140, binding = 0) uniform View {
  mat4 to_clip;  // from the scene to clip coordinates; reversed depth
  vec4 eye;      // xyz: of the scene; w: distance of the near plane
  vec4 light;    // xyz: unit vector towards the light; w: 1 with lighting, 0 without
  vec4 pixel;    // x: size of a pixel at depth 1; y: 1 where the sign of normals means nothing
};

vec3 linear_from_srgb(vec3 c) {
  return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), greaterThan(c, vec3(0.04045)));
}

// Diffuse light from near the eye, with a part that comes from everywhere so that nothing is black.
// The result is linear light.
vec3 shade(vec3 srgb, vec3 normal) {
  const float ambient = 0.4;
  float diffuse = max(dot(normal, light.xyz), 0.0);
  return linear_from_srgb(srgb) * mix(1.0, mix(ambient, 1.0, diffuse), light.w);
}

// Unit vector from a point of the scene to the eye; never NaN.
vec3 towards_eye(vec3 p) {
  vec3 d = eye.xyz - p;
  float l2 = dot(d, d);
  return l2 > 0.0 ? d * inversesqrt(l2) : light.xyz;
}

// The normal as it is used: the side towards the eye where its sign means nothing.
vec3 oriented(vec3 n, vec3 to_eye) {
  return pixel.y > 0.5 && dot(n, to_eye) < 0.0 ? -n : n;
}

// The paper's round Gaussian mask, section V-B, as a function instead of a texture: 1 in the middle
// of a surfel, three standard deviations to its edge, 0 outside.
float gaussian_mask(vec2 at) {
  float d2 = dot(at, at);
  return d2 > 1.0 ? 0.0 : exp(-4.5 * d2);
}
