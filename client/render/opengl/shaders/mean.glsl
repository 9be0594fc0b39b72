// The weighted mean of a pixel's splats, from the sums of weighted colours (rgb) and of weights (a).
// Returns the colour with alpha 1, or all 0 if there are no splats.
vec4 mean_of(vec4 sum) {
  const float nothing = 1e-6;  // below the weight at the rim of a splat, above rounding errors
  return sum.a >= nothing ? vec4(sum.rgb / sum.a, 1.0) : vec4(0.0);
}
