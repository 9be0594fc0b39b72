// First pass of splatting: depth only, of a disc.
void main() {
  if (!(footprint() <= 1.0)) discard;
}
