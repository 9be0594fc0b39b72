// A line of the floor. It fades out towards the rim of the disc, and where it comes too close to its
// neighbours in the picture.
in vec3 place;
noperspective in float side;
flat in vec3 direction;
flat in float strength, step_to_next;
flat in float half_width;

layout(location = 0) uniform vec4 line_color;  // linear
layout(location = 1) uniform float reach;      // radius of the disc
layout(location = 2) uniform int up_axis;

layout(location = 0) out vec4 color;

// The distance in pixels to the next line of the same strength.
float pixels_to_next() {
  vec3 up = vec3(0.0);
  up[up_axis] = 1.0;
  vec3 x, y;
  window_slopes(place - eye.xyz, 1.0 / gl_FragCoord.w, x, y);
  vec3 across = cross(up, direction);
  vec2 along = vec2(dot(x, direction), dot(y, direction));
  vec2 next = step_to_next * vec2(dot(x, across), dot(y, across));
  return abs(along.x * next.y - along.y * next.x) * inversesqrt(max(dot(along, along), 1e-12));
}

void main() {
  float coverage = clamp(half_width + 0.5 - abs(side), 0.0, 1.0);
  float rim = 1.0 - smoothstep(0.35, 1.0, length(place) / reach);
  float crowding = smoothstep(4.0 * half_width, 20.0 * half_width, pixels_to_next());
  color = vec4(line_color.rgb, line_color.a * strength * coverage * rim * crowding);
}
