uint kind_of(Instance surfel) {
  // A surfel that shows its back is not seen.
  vec3 to_eye = towards_eye(surfel.center);
  if (dot(surfel_normal(surfel, to_eye), to_eye) <= 0.0) return kHidden;
  return kind_of(surfel.center, 1.41422 * largest_scale * surfel.radius,
                 largest_scale * sprite_size(surfel));
}
