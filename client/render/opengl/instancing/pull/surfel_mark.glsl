uint kind_of(Instance surfel) {
  // A surfel that shows its back is hidden.
  bool has_back = pixel.y < 0.5 && dot(surfel.normal, surfel.normal) > 0.25;
  if (has_back && dot(surfel.normal, eye.xyz - surfel.center) <= 0.0) return kHidden;
  return kind_of(surfel.center, 1.41422 * largest_scale * surfel.radius);
}
