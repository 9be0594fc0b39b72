// What the three steps of listing share. What can be seen becomes a sprite, where a point can cover
// it, or a solid, which is drawn as other methods draw it. A word stands for 32 instances: a bit
// for each, and how many were listed before.
struct Word {
  uint sprites, solids;
  uint sprites_before, solids_before;
};

layout(binding = 0) uniform usamplerBuffer instances;  // as texture/fetch.glsl has them
layout(std430, binding = 1) buffer Words { Word words[]; };

layout(location = 2) uniform uint instance_count;

Instance fetch_instance(uint i) {
  int at = 2 * int(i);
  return unpack_instance(texelFetch(instances, at), texelFetch(instances, at + 1));
}
