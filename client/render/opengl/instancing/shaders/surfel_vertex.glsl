// The corners of a surfel's quad, as a triangle strip.
layout(location = 0) uniform float scale;      // factor for the radius
layout(location = 1) uniform float tolerance;  // how far the quad is pushed back, in scaled radii

out vec2 mask;  // -1 to 1 across the quad
flat out vec3 linear_color;

const int kVertices = 4;
const bool kIsFan = false;

void set_vertex(Element e, int number) {
  mask = vec2(number & 1, number >> 1) * 2.0 - 1.0;
  gl_Position = e.center + scale * (mask.x * e.u + mask.y * e.v);
  // Moving a point away from the eye by a factor divides its reversed depth by that factor and
  // changes nothing else. FORMULAS.md, "Two-pass depth tolerance".
  gl_Position.z /= 1.0 + tolerance * scale * e.away;
  linear_color = e.color;
}
