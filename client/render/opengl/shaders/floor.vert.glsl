// A line of the floor (floor_grid.h) as a quad of constant width in the picture. Both ends are in
// front of the eye.
layout(location = 0) in vec3 from;
layout(location = 1) in vec3 to;
layout(location = 2) in vec2 strength_step;

out vec3 place;
noperspective out float side;  // distance from the middle of the line, in pixels
flat out vec3 direction;       // along the line
flat out float strength, step_to_next;
flat out float half_width;     // in pixels

vec2 in_window(vec4 clip) { return 0.5 * window.xy * clip.xy / clip.w; }

void main() {
  vec4 a = to_clip * vec4(from, 1.0), b = to_clip * vec4(to, 1.0);
  vec2 along = in_window(b) - in_window(a);
  vec2 across = vec2(-along.y, along.x) * inversesqrt(max(dot(along, along), 1e-12));
  bool second = gl_VertexID >= 2;
  half_width = 0.5 * max(1.0, window.y / 720.0);
  // The line fades out over half a pixel more on each side.
  side = (half_width + 0.5) * ((gl_VertexID & 1) == 0 ? -1.0 : 1.0);
  place = second ? to : from;
  direction = normalize(to - from);
  strength = strength_step.x;
  step_to_next = strength_step.y;
  gl_Position = second ? b : a;
  gl_Position.xy += 2.0 * side * across / window.xy * gl_Position.w;
}
