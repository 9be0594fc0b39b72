// Shared by the three steps that list the visible instances. An instance becomes a sprite if a GL
// point can cover it, else a solid, which is drawn as by the other methods. A word stands for 32
// instances. It has a bit for each, and counts how many are listed before them.
struct Word {
  uint sprites, solids;
  uint sprites_before, solids_before;
};

layout(binding = 0) uniform usamplerBuffer instances;  // two texels each, as in texture/fetch.glsl
layout(std430, binding = 1) buffer Words { Word words[]; };

layout(location = 2) uniform uint instance_count;

Instance fetch_instance(uint i) {
  int at = 2 * int(i);
  return unpack_instance(texelFetch(instances, at), texelFetch(instances, at + 1));
}
