// Third step: what can be seen, without gaps and in its order.
layout(local_size_x = 64) in;

layout(std430, binding = 3) writeonly buffer Elements { Element elements[]; };

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= instance_count) return;
  Word word = words[i / 32u];
  uint bit = 1u << (i % 32u);
  if ((word.seen & bit) == 0u) return;
  elements[word.before + uint(bitCount(word.seen & (bit - 1u)))] = place(fetch_instance(i));
}
