// First pass of splatting: depth only, of a disc.
in vec2 mask;

void main() {
  if (dot(mask, mask) > 1.0) discard;
}
