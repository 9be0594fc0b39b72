// Sprites from the list that write.comp.glsl has made.
layout(binding = 0) uniform usamplerBuffer sprites;

Sprite fetch_sprite(int i) {
  vec4 a = uintBitsToFloat(texelFetch(sprites, 3 * i)),
       b = uintBitsToFloat(texelFetch(sprites, 3 * i + 1)),
       c = uintBitsToFloat(texelFetch(sprites, 3 * i + 2));
  return Sprite(a.xyz, a.w, b.xyz, b.w, c.xyz, c.w);
}
