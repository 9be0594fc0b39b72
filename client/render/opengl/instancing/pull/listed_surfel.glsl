// Sprites from the list that write.comp.glsl has made.
layout(binding = 0) uniform usamplerBuffer sprites;

Sprite fetch_sprite(int i) {
  uvec4 a = texelFetch(sprites, 3 * i), b = texelFetch(sprites, 3 * i + 1),
        c = texelFetch(sprites, 3 * i + 2);
  return Sprite(uintBitsToFloat(a.xy), uintBitsToFloat(a.z), uintBitsToFloat(a.w),
                uintBitsToFloat(b.xyz), b.w, uintBitsToFloat(c.xy), c.z, c.w);
}
