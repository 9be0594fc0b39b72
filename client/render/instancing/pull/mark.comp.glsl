// First step: which instances can be seen.
layout(local_size_x = 64) in;

void main() {
  uint word = gl_GlobalInvocationID.x;
  uint first = 32u * word;
  if (first >= instance_count) return;
  uint seen = 0u;
  uint count = min(32u, instance_count - first);
  for (uint i = 0u; i < count; ++i) {
    if (visible(fetch_instance(first + i))) seen |= 1u << i;
  }
  words[word].seen = seen;
}
