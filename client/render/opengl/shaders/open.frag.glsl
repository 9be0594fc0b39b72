// The depth, the share of the light from all around that nothing nearby takes, and the mean curvature
// of squares of two by two pixels.
layout(binding = 0) uniform sampler2D sums;
layout(binding = 1) uniform sampler2D normals;
layout(binding = 2) uniform sampler2D depth;

layout(location = 0) uniform vec2 taps[48];  // of four turns

layout(location = 0) out vec4 cell;

// > 0 where the surface bulges. `unit` is the size of a pixel there.
float bend_at(ivec2 at, vec3 place, vec3 normal, float unit) {
  const vec2 kAround[8] = vec2[](vec2(1.0, 0.0), vec2(0.7071, 0.7071), vec2(0.0, 1.0),
                                 vec2(-0.7071, 0.7071), vec2(-1.0, 0.0), vec2(-0.7071, -0.7071),
                                 vec2(0.0, -1.0), vec2(0.7071, -0.7071));
  ivec2 size = textureSize(depth, 0);
  float far = clamp(kBend * reach.y / unit, kLeastBend, kMostBend), farthest = 3.0 * far * unit;
  float bend = 0.0, count = 0.0;
  for (int i = 0; i < 8; ++i) {
    ivec2 there = at + ivec2(floor(far * kAround[i] + 0.5));
    if (any(lessThan(there, ivec2(0))) || any(greaterThanEqual(there, size))) continue;
    float other = texelFetch(depth, there, 0).x;
    if (other == 0.0 || texelFetch(sums, there, 0).a < 1e-6) continue;
    vec3 ray = pixel_ray(vec2(there) + 0.5), away = eye.w / other * ray - place;
    float distance2 = dot(away, away);
    if (distance2 > farthest * farthest) continue;
    vec3 turn = shading_normal(texelFetch(normals, there, 0), -normalize(ray)) - normal;
    bend += dot(turn, away) / max(distance2, 1e-30);
    count += 1.0;
  }
  return count > 0.0 ? bend / count : 0.0;
}

void main() {
  ivec2 square = ivec2(gl_FragCoord.xy), size = textureSize(depth, 0), at;
  bool any_drawn = false;
  for (int i = 0; i < 4 && !any_drawn; ++i) {
    at = min(2 * square + ivec2(i & 1, i >> 1), size - 1);
    any_drawn = texelFetch(sums, at, 0).a >= 1e-6 && texelFetch(depth, at, 0).x > 0.0;
  }
  cell = vec4(0.0, 1.0, 0.0, 1.0);
  if (!any_drawn) return;
  float own = texelFetch(depth, at, 0).x, w = eye.w / own;
  vec3 ray = pixel_ray(vec2(at) + 0.5), place = w * ray;
  vec3 normal = shading_normal(texelFetch(normals, at, 0), -normalize(ray));
  float most = clamp(reach.x / (pixel.x * w), kLeastReach, kMostReach * float(size.y));
  float tolerance = 0.02 * reach.x + 2.0 * pixel.x * w;
  float taken = 0.0;
  int turn = (square.x & 1) + 2 * (square.y & 1);
  for (int i = 0; i < kTaps; ++i) {
    ivec2 there = at + ivec2(floor(most * taps[kTaps * turn + i] + 0.5));
    if (any(lessThan(there, ivec2(0))) || any(greaterThanEqual(there, size))) continue;
    float other = texelFetch(depth, there, 0).x;
    if (other == 0.0) continue;
    vec3 away = eye.w / other * pixel_ray(vec2(there) + 0.5) - place;
    float distance2 = dot(away, away), above = dot(away, normal) - tolerance;
    float near_share = 1.0 - distance2 / (reach.x * reach.x);
    if (above > 0.0 && near_share > 0.0) taken += near_share * above * inversesqrt(distance2 + 1e-30);
  }
  cell = vec4(own, max(0.0, 1.0 - kOcclusion / float(kTaps) * taken), 0.0, 1.0);
  if (reach.z == kCurvature) cell.z = bend_at(at, place, normal, pixel.x * w);
}
