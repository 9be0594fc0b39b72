// Included in every stage. Coordinates of the scene are relative to the origin of its instances.
layout(std140, binding = 0) uniform View {
  mat4 to_clip;  // from the scene to clip coordinates, with reversed depth
  vec4 eye;      // xyz: position in the scene; w: distance of the near plane
  vec4 light;    // xyz: unit vector towards the light; w: its strength, 0 without lighting,
                 // and 2 to draw 0.5 + 0.5 n in place of colours
  vec4 pixel;    // x: size of a pixel at depth 1; y: 1 if the signs of normals are unknown, else 0
  // The ray from the eye through window coordinates (x, y), scaled to depth 1, is
  // ray_corner + x ray_x + y ray_y (xyz).
  vec4 ray_corner, ray_x, ray_y;
  vec4 window;  // xy: size of the picture in pixels
};

// The gradient of clip coordinate i in the scene.
vec3 clip_row(int i) { return vec3(to_clip[0][i], to_clip[1][i], to_clip[2][i]); }

// The gradients of the window coordinates x and y, in pixels, at a point of depth w.
void window_slopes(vec3 from_eye, float w, out vec3 x, out vec3 y) {
  vec3 right = clip_row(0), up = clip_row(1), forward = clip_row(3);
  vec2 scale = 0.5 * window.xy / w;
  x = scale.x * (right - dot(right, from_eye) / w * forward);
  y = scale.y * (up - dot(up, from_eye) / w * forward);
}

vec3 pixel_ray(vec2 at) {
  return ray_corner.xyz + at.x * ray_x.xyz + at.y * ray_y.xyz;
}

// Diffuse light from near the eye, and ambient light so that nothing is black.
float light_on(vec3 normal) {
  const float ambient = 0.4;
  float diffuse = max(dot(normal, light.xyz), 0.0);
  return mix(1.0, mix(ambient, 1.0, diffuse), light.w);
}

// What is drawn in place of a colour.
vec3 lit_color(vec3 color, vec3 normal) {
  return light.w > 1.5 ? 0.5 + 0.5 * normal : color * light_on(normal);
}

// The unit vector from a point of the scene to the eye. Never NaN.
vec3 towards_eye(vec3 p) {
  vec3 d = eye.xyz - p;
  float l2 = dot(d, d);
  return l2 > 0.0 ? d * inversesqrt(l2) : light.xyz;
}

// Turns a normal whose sign is unknown towards the eye.
vec3 oriented(vec3 n, vec3 to_eye) {
  return pixel.y > 0.5 && dot(n, to_eye) < 0.0 ? -n : n;
}

// The weight of a surfel at the squared distance d2 from its centre; 1 is its rim. FORMULAS.md,
// "Surfel mask".
float gaussian_mask(float d2) { return d2 <= 1.0 ? exp(-4.5 * d2) : 0.0; }
