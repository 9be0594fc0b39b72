// Second step, one group: how many are listed before each word, and the draw commands for them all.
layout(local_size_x = 256) in;

layout(std430, binding = 2) writeonly buffer Commands {
  uint sprite_count, sprite_instances, first_sprite, sprite_base_instance;
  uint index_count, solid_instances, first_index, base_vertex, solid_base_instance;
};

layout(location = 4) uniform uint indices_per_solid;

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
    sprite_count = before.x;
    index_count = before.y * indices_per_solid;
    sprite_instances = solid_instances = 1u;
    first_sprite = sprite_base_instance = 0u;
    first_index = base_vertex = solid_base_instance = 0u;
  }
}
