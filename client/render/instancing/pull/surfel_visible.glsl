// False where the surfel shows its back, or lies outside of the picture, enlarged by largest_scale.
bool visible(Instance surfel) {
  vec3 to_eye = towards_eye(surfel.center);
  if (dot(surfel_normal(surfel, to_eye), to_eye) <= 0.0) return false;
  return sphere_in_view(surfel.center, 1.41422 * largest_scale * surfel.radius);
}
