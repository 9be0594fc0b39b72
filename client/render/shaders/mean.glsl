// The weighted mean of a pixel's splats, from the sums of weighted colours (rgb) and of weights (a):
// its colour and 1, or all 0 where there are no splats.
vec4 mean_of(vec4 sum) {
  const float nothing = 1e-6;  // less than the weight at the rim of a splat, more than rounding
  return sum.a >= nothing ? vec4(sum.rgb / sum.a, 1.0) : vec4(0.0);
}
