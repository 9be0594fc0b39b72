// An instance from a uniform buffer of 64 KiB, the size that all drivers support.
layout(std140, binding = 1) uniform Batch { uvec4 words[4096]; };

Instance fetch_instance() {
  return unpack_instance(words[2 * gl_InstanceID], words[2 * gl_InstanceID + 1]);
}
