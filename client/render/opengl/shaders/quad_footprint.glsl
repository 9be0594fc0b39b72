// Where a fragment lies on its surfel, if the surfel is drawn as a quad.
in vec2 mask;  // -1 to 1 across the quad

// The squared distance from the centre of the surfel; 1 at its rim.
float footprint() { return dot(mask, mask); }
