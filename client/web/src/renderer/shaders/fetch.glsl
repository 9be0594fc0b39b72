// An instance from a texture with rows of 2048 instances, two texels each.
layout(binding = 0) uniform usampler2D words;

Instance fetch_instance(int i) {
  ivec2 at = ivec2(2 * (i & 2047), i >> 11);
  return unpack_instance(texelFetch(words, at, 0), texelFetch(words, at + ivec2(1, 0), 0));
}

Instance fetch_instance() { return fetch_instance(gl_VertexID); }
