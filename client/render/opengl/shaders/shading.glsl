// What shading pixels needs (render/shading.h, where the formulas have their sources).
layout(std140, binding = 1) uniform Shading {
  mat4 to_environment;  // rotates directions of the scene
  mat4 to_shadow;       // to the map of the key light; z from 0 to 1 towards the light
  vec4 diffuse[9];      // spherical harmonics of the light that a white surface returns
  vec4 key_direction;   // xyz: in the scene; w: z of shadow that is not one
  vec4 key;             // rgb; w: roughness
  vec4 scene_up;        // xyz; w: the height of the floor
  vec4 reach;           // x: of occlusion; y: radius of all; z: what colours show; w: 2 with light
  vec4 scale;           // x: between contours; y: height of the origin above one; z, w: depths
};

const float kLeastFacing = 0.05, kReflectance = 0.04, kOcclusion = 2.0, kLeak = 0.25,
            kFloorShadow = 0.65, kLeastReach = 3.0, kMostReach = 0.12;
const float kBend = 0.012, kLeastBend = 2.0, kMostBend = 24.0, kHalfBend = 25.0;
const int kTaps = 12;
// What colours show (ColorSource).
const float kCurvature = 3.0, kAccessibility = 4.0, kDepth = 5.0;

// The normal with which a pixel is shaded, from a sum of 0.5 + 0.5 n and of weights. Where the
// surfaces that it shows do not agree, or seem to face away, it is turned towards the eye.
vec3 shading_normal(vec4 sum, vec3 to_eye) {
  vec3 mean = 2.0 * sum.xyz / sum.w - 1.0;
  vec3 n = normalize(mean + max(1.0 - length(mean), 0.0) * to_eye);
  float facing = dot(n, to_eye);
  return facing >= kLeastFacing ? n : normalize(n + (kLeastFacing - facing) * to_eye);
}

// The share of the key light that reaches a point.
float key_light_at(sampler2D moments, vec3 point) {
  vec3 at = (to_shadow * vec4(point, 1.0)).xyz;
  vec2 texel = at.xy * vec2(textureSize(moments, 0)) - 0.5;
  if (any(lessThan(texel, vec2(0.0))) ||
      any(greaterThanEqual(texel, vec2(textureSize(moments, 0) - 1)))) return 1.0;
  vec2 mean = textureLod(moments, at.xy, 0.0).xy;
  float behind = mean.x - max(at.z, 0.0) - key_direction.w;
  if (!(behind > 0.0)) return 1.0;
  float variance = max(mean.y - mean.x * mean.x, 1e-6);
  float most = variance / (variance + behind * behind);
  return clamp((most - kLeak) / (1.0 - kLeak), 0.0, 1.0);
}
