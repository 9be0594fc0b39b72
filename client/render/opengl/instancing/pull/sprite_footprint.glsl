// Where a fragment lies on its surfel, if the surfel is drawn as a GL point. Also sets the depth.
flat in vec2 middle;
flat in vec3 conic;
flat in vec4 depth_plane;

// The squared distance from the centre of the surfel; 1 at its rim.
float footprint() {
  vec2 d = gl_FragCoord.xy - middle;
  float change = dot(depth_plane.yz, d);
  gl_FragDepth = depth_plane.x + clamp(change, -depth_plane.w, depth_plane.w);
  return d.x * (conic.x * d.x + conic.y * d.y) + conic.z * d.y * d.y;
}
