// The second step, by a single work group: counts how many instances are listed before each word, and
// writes the draw commands.
layout(local_size_x = 256) in;

layout(std430, binding = 2) writeonly buffer Commands {
  // The components are: vertices, instances, first vertex, first instance.
  uvec4 draw_sprites, draw_solids;
};

layout(location = 4) uniform uint vertices_per_solid;

shared uvec2 totals[256];

uvec2 seen(uint word) { return uvec2(bitCount(words[word].sprites), bitCount(words[word].solids)); }

void main() {
  uint me = gl_LocalInvocationID.x;
  uint count = (instance_count + 31u) / 32u;
  uint run = (count + 255u) / 256u;
  uint begin = min(me * run, count), end = min(begin + run, count);
  uvec2 total = uvec2(0u);
  for (uint i = begin; i < end; ++i) total += seen(i);
  totals[me] = total;
  barrier();
  uvec2 before = uvec2(0u);
  for (uint i = 0u; i < me; ++i) before += totals[i];
  for (uint i = begin; i < end; ++i) {
    words[i].sprites_before = before.x;
    words[i].solids_before = before.y;
    before += seen(i);
  }
  if (me == 255u) {
    draw_sprites = uvec4(before.x, 1u, 0u, 0u);
    draw_solids = uvec4(before.y * vertices_per_solid, 1u, 0u, 0u);
  }
}
