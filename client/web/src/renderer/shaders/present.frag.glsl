// Copies the picture to where it is shown, which may have more pixels.
layout(binding = 0) uniform sampler2D picture;

layout(location = 0) uniform bool see_through;  // what is behind the scene shows where nothing was drawn

layout(location = 0) out vec4 shown;

void main() {
  vec4 there = textureLod(picture, (gl_FragCoord.xy - window.zw) / window.xy, 0.0);
  shown = vec4(srgb_from_linear(there.rgb), 1.0);
  if (see_through) shown *= there.a;
}
