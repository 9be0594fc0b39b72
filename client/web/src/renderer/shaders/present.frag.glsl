// Copies the picture to the canvas, which may have more pixels.
layout(binding = 0) uniform sampler2D picture;

layout(location = 0) out vec4 shown;

void main() {
  vec4 there = textureLod(picture, gl_FragCoord.xy / window.xy, 0.0);
  shown = vec4(srgb_from_linear(there.rgb), 1.0);
}
