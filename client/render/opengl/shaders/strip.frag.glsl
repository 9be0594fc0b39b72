// A pixel of a triangle, lit by the normal that is interpolated there. The weight, 1, is that of
// the sums that the means of surfels come from (mean.glsl).
in vec3 linear_color;
in vec3 normal_there;
in vec3 from_eye;

layout(location = 0) out vec4 color;

void main() {
  float n2 = dot(normal_there, normal_there), away2 = dot(from_eye, from_eye);
  vec3 normal = n2 > 1e-3   ? normal_there * inversesqrt(n2)
              : away2 > 0.0 ? -from_eye * inversesqrt(away2)
                            : light.xyz;
  color = vec4(lit_color(linear_color, normal), 1.0);
}
