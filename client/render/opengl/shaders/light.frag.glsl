// Lights a pixel once it is known what it shows. Colours come and go as sums of weighted colours and
// of weights.
layout(binding = 0) uniform sampler2D sums;
layout(binding = 1) uniform sampler2D normals;
layout(binding = 2) uniform sampler2D depth;
layout(binding = 3) uniform sampler2D open;
layout(binding = 4) uniform sampler2D shadow;
layout(binding = 5) uniform sampler2D glossy;

layout(location = 0) out vec4 lit_sum;

// x: open; y: curvature.
vec2 cell_at(ivec2 at, float own) {
  ivec2 side = ivec2((at.x & 1) != 0 ? 1 : -1, (at.y & 1) != 0 ? 1 : -1);
  vec2 sum = vec2(0.0);
  float weights = 0.0;
  for (int i = 0; i < 4; ++i) {
    ivec2 there = clamp(at / 2 + ivec2(i & 1, i >> 1) * side, ivec2(0), textureSize(open, 0) - 1);
    vec3 cell = texelFetch(open, there, 0).xyz;
    float weight = abs(cell.x - own) < 0.02 * own ? 1.0 : 1e-3;
    sum += weight * cell.yz;
    weights += weight;
  }
  return sum / weights;
}

vec3 diffuse_light(vec3 n) {
  return max((diffuse[0] + diffuse[1] * n.y + diffuse[2] * n.z + diffuse[3] * n.x +
              diffuse[4] * (n.x * n.y) + diffuse[5] * (n.y * n.z) +
              diffuse[6] * (3.0 * n.z * n.z - 1.0) + diffuse[7] * (n.x * n.z) +
              diffuse[8] * (n.x * n.x - n.y * n.y)).rgb, 0.0);
}

vec3 glossy_light(vec3 d) {
  vec2 p = d.xz / (abs(d.x) + abs(d.y) + abs(d.z));
  if (d.y < 0.0) p = mix(vec2(-1.0), vec2(1.0), greaterThanEqual(p, vec2(0.0))) * (1.0 - abs(p.yx));
  vec2 edge = vec2(textureSize(glossy, 0));
  return textureLod(glossy, ((0.5 * p + 0.5) * (edge - 2.0) + 1.0) / edge, 0.0).rgb;
}

vec2 environment_share(float roughness, float facing) {
  float a = 1.0 - roughness, b = 0.0425 - 0.0275 * roughness;
  float falling = 1.0 / (1.0 + 0.85 * facing);
  falling *= falling;
  falling *= falling;
  falling *= falling;
  float share = min(a * a, falling) * a + b;
  return vec2(1.04 - 0.572 * roughness - 1.04 * share, 1.04 * share - 0.04 + 0.022 * roughness);
}

float highlight_of(float alpha2, float half_cosine, float facing, float lit, float half_facing) {
  float base = half_cosine * half_cosine * (alpha2 - 1.0) + 1.0;
  float k = 0.5 * sqrt(alpha2);
  float masking = (facing * (1.0 - k) + k) * (lit * (1.0 - k) + k);
  float away = 1.0 - half_facing, away2 = away * away;
  float fresnel = kReflectance + (1.0 - kReflectance) * away2 * away2 * away;
  return 0.25 * alpha2 * fresnel / (base * base * masking);
}

vec3 ramp(vec3 colors[5], float share) {
  float at = clamp(share, 0.0, 1.0) * 4.0;
  int first = min(int(at), 3);
  return mix(colors[first], colors[first + 1], at - float(first));
}

// The colour of a pixel that shows what a surface is like.
vec3 false_color(float openness, float bend, float w, vec3 place, vec3 ray, vec3 normal) {
  if (reach.z == kCurvature) {
    float scaled = bend * reach.y / kHalfBend;
    return ramp(vec3[](vec3(0.02, 0.10, 0.45), vec3(0.10, 0.32, 0.62), vec3(0.62, 0.62, 0.60),
                       vec3(0.85, 0.40, 0.10), vec3(0.60, 0.10, 0.02)),
                0.5 + 0.5 * scaled / (1.0 + abs(scaled)));
  }
  if (reach.z == kAccessibility)
    return ramp(vec3[](vec3(0.01, 0.01, 0.03), vec3(0.12, 0.05, 0.04), vec3(0.30, 0.17, 0.10),
                       vec3(0.56, 0.40, 0.27), vec3(0.80, 0.76, 0.68)),
                openness * openness * openness);
  if (reach.z == kDepth)
    return ramp(vec3[](vec3(0.98, 0.80, 0.02), vec3(0.12, 0.58, 0.12), vec3(0.02, 0.27, 0.26),
                       vec3(0.05, 0.08, 0.25), vec3(0.06, 0.00, 0.09)),
                (w - scale.z) / (scale.w - scale.z));
  // Lines of the same width, from the change of height per pixel on the plane of the surface.
  float along = min(dot(normal, ray), -1e-3);
  vec3 x = ray_x.xyz - dot(normal, ray_x.xyz) / along * ray,
       y = ray_y.xyz - dot(normal, ray_y.xyz) / along * ray;
  vec2 slope = w / scale.x * vec2(dot(scene_up.xyz, x), dot(scene_up.xyz, y));
  float steep = max(length(slope), 1e-6);
  float height = (dot(place, scene_up.xyz) + scale.y) / scale.x, nearest = floor(height + 0.5);
  bool strong = abs(nearest - 5.0 * floor(nearest / 5.0 + 0.5)) < 0.5;
  float line = clamp((strong ? 1.5 : 1.0) - abs(height - nearest) / steep, 0.0, 1.0) *
               clamp(2.0 - 5.0 * steep, 0.0, 1.0);
  return mix(vec3(0.62, 0.60, 0.56), vec3(0.10, 0.03, 0.01), (strong ? 1.0 : 0.7) * line);
}

// Light up to kLinear stays, and all light above it fits below 1.
vec3 tone(vec3 light) {
  const float kLinear = 0.6;
  vec3 more = max(light - kLinear, 0.0) / (1.0 - kLinear);
  return min(light, kLinear) + (1.0 - kLinear) * more / (1.0 + more);
}

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec4 sum = texelFetch(sums, at, 0);
  float own = texelFetch(depth, at, 0).x;
  lit_sum = sum;
  if (sum.a < 1e-6 || !(own > 0.0)) return;
  float roughness = key.w, alpha2 = roughness * roughness * roughness * roughness;
  vec3 ray = pixel_ray(gl_FragCoord.xy), place = eye.w / own * ray, to_eye = -normalize(ray);
  vec3 normal = shading_normal(texelFetch(normals, at, 0), to_eye);
  vec2 cell = cell_at(at, own);
  vec3 surface = reach.z == 0.0
                     ? sum.rgb / sum.a
                     : false_color(cell.x, cell.y, eye.w / own, eye.xyz + place, ray, normal);
  if (reach.w < 1.5) {
    float shade = 0.4 + 0.6 * max(dot(normal, light.xyz), 0.0);
    lit_sum = vec4(surface * mix(1.0, shade, reach.w), 1.0) * sum.a;
    return;
  }
  float around = reach.z == kAccessibility ? 1.0 : cell.x, facing = max(dot(normal, to_eye), 1e-3),
        lit = dot(normal, key_direction.xyz);
  mat3 turned = mat3(to_environment);
  vec3 returned = around * diffuse_light(turned * normal);
  vec2 part = environment_share(roughness, facing);
  vec3 mirrored = 2.0 * dot(normal, to_eye) * normal - to_eye;
  vec3 highlight = around * (kReflectance * part.x + part.y) * glossy_light(turned * mirrored);
  if (lit > 0.0) {
    float reaches = lit * key_light_at(shadow, eye.xyz + place);
    vec3 middle = normalize(to_eye + key_direction.xyz);
    returned += reaches * key.rgb;
    highlight += reaches * highlight_of(alpha2, max(dot(normal, middle), 0.0), facing, lit,
                                        dot(to_eye, middle)) * key.rgb;
  }
  lit_sum = vec4(tone(surface * returned + highlight), 1.0) * sum.a;
}
