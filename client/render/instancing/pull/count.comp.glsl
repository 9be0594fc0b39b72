// Second step, one group: how many are listed before each word, and the draw command for them all.
layout(local_size_x = 256) in;

layout(std430, binding = 2) writeonly buffer Command {
  uint index_count, draw_count, first_index, base_vertex, base_instance;
};

layout(location = 4) uniform uint indices_per_instance;

shared uint totals[256];

void main() {
  uint me = gl_LocalInvocationID.x;
  uint count = (instance_count + 31u) / 32u;
  uint run = (count + 255u) / 256u;
  uint begin = min(me * run, count), end = min(begin + run, count);
  uint total = 0u;
  for (uint i = begin; i < end; ++i) total += uint(bitCount(words[i].seen));
  totals[me] = total;
  barrier();
  uint before = 0u;
  for (uint i = 0u; i < me; ++i) before += totals[i];
  for (uint i = begin; i < end; ++i) {
    words[i].before = before;
    before += uint(bitCount(words[i].seen));
  }
  if (me == 255u) {
    index_count = before * indices_per_instance;
    draw_count = 1u;
    first_index = base_vertex = base_instance = 0u;
  }
}
