// The share of its light that the floor keeps.
layout(binding = 0) uniform sampler2D shadow;

layout(location = 0) out vec4 factor;

void main() {
  vec3 ray = pixel_ray(gl_FragCoord.xy);
  float height = dot(eye.xyz, scene_up.xyz) - scene_up.w, down = -dot(ray, scene_up.xyz);
  if (!(height > 0.0) || !(down > 0.0)) discard;
  factor = vec4(1.0 - kFloorShadow * (1.0 - key_light_at(shadow, eye.xyz + height / down * ray)));
}
