// Where a fragment lies on its surfel, for quads.
in vec2 mask;  // -1 to 1 across the quad

// Squared distance from the middle; 1 at the rim.
float footprint() { return dot(mask, mask); }
