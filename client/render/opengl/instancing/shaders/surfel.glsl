// A surfel as an oriented quad: Slomp et al., Geometry Instancing, section V-A, corrected as
// FORMULAS.md says under "Surfel frame" and "Surfel transform". An Element holds what the vertices
// have in common, for every scale.
struct Element {
  vec4 center, u, v;  // clip coordinates
  vec3 color;         // linear
  float away;         // radius divided by the distance from the eye
};

// The tangents of a unit normal; (u, v, n) is orthonormal and right-handed.
void surfel_frame(vec3 n, out vec3 u, out vec3 v) {
  bool at_pole = n.x * n.x + n.z * n.z < 1e-12;
  vec3 a = at_pole ? vec3(0.0, 0.0, -1.0) : vec3(0.0, 1.0, 0.0);
  u = normalize(cross(a, n));
  v = cross(n, u);
}

// The normal with which a surfel is drawn. A surfel of unknown orientation faces the eye.
vec3 surfel_normal(Instance surfel, vec3 to_eye) {
  bool known = dot(surfel.normal, surfel.normal) > 0.25;
  return known ? normalize(oriented(surfel.normal, to_eye)) : to_eye;
}

Element place(Instance surfel) {
  vec3 n = surfel_normal(surfel, towards_eye(surfel.center));
  vec3 u, v;
  surfel_frame(n, u, v);
  return Element(to_clip * vec4(surfel.center, 1.0), to_clip * vec4(surfel.radius * u, 0.0),
                 to_clip * vec4(surfel.radius * v, 0.0), lit_color(surfel.color, n),
                 surfel.radius / max(distance(eye.xyz, surfel.center), eye.w));
}
