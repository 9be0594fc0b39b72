// The first pass of splatting: only the depth of a disc.
void main() {
  if (!(footprint() <= 1.0)) discard;
}
