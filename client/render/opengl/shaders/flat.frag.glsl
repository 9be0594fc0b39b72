// Faces of voxels have a single colour each. The framebuffer encodes it as sRGB.
flat in vec3 linear_color;

layout(location = 0) out vec4 color;

void main() {
  color = vec4(linear_color, 1.0);
}
