// An instance from a texture buffer.
layout(binding = 0) uniform usamplerBuffer words;

Instance fetch_instance() {
  return unpack_instance(texelFetch(words, 2 * gl_InstanceID),
                         texelFetch(words, 2 * gl_InstanceID + 1));
}
