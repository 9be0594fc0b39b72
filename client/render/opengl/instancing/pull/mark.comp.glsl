// The first step: decides whether instances are hidden, sprites or solids.
layout(local_size_x = 64) in;

void main() {
  uint word = gl_GlobalInvocationID.x;
  uint first = 32u * word;
  if (first >= instance_count) return;
  uint sprites = 0u, solids = 0u;
  uint count = min(32u, instance_count - first);
  for (uint i = 0u; i < count; ++i) {
    uint kind = kind_of(fetch_instance(first + i));
    if (kind == kSprite) sprites |= 1u << i;
    if (kind == kSolid) solids |= 1u << i;
  }
  words[word].sprites = sprites;
  words[word].solids = solids;
}
