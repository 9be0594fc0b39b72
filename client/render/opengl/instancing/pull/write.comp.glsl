// The third step: writes the visible instances without gaps and in their order.
layout(local_size_x = 64) in;

layout(std430, binding = 3) writeonly buffer Sprites { Sprite sprites[]; };
layout(std430, binding = 4) writeonly buffer Solids { Element solids[]; };

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= instance_count) return;
  Word word = words[i / 32u];
  uint bit = 1u << (i % 32u);
  uint before = bit - 1u;
  if ((word.sprites & bit) != 0u) {
    uint at = word.sprites_before + uint(bitCount(word.sprites & before));
    sprites[at] = make_sprite(fetch_instance(i));
  } else if ((word.solids & bit) != 0u) {
    uint at = word.solids_before + uint(bitCount(word.solids & before));
    solids[at] = place(fetch_instance(i));
  }
}
