#include <algorithm>
#include <cmath>

#include "datasets_synthetic/body.h"
#include "datasets_synthetic/texture.h"

namespace pointreel {
namespace {

constexpr glm::u8vec3 kSkin{224, 172, 138}, kHair{58, 38, 26}, kEye{40, 60, 90}, kLip{176, 84, 80},
    kWhite{238, 236, 228}, kTeal{24, 132, 140}, kRed{196, 48, 44}, kNavy{40, 56, 110},
    kYellow{248, 204, 40}, kDenim{52, 74, 118}, kBelt{70, 44, 28}, kShoe{36, 36, 40},
    kSoleWhite{220, 220, 216};

bool in_ellipse(double x, double y, double rx, double ry) {
  return (x / rx) * (x / rx) + (y / ry) * (y / ry) <= 1.0;
}

glm::u8vec3 face(const glm::dvec3& q) {
  if (q.z > 0.06) {
    if (in_ellipse(std::abs(q.x) - 0.031, q.y - 1.648, 0.013, 0.007)) {
      return in_ellipse(std::abs(q.x) - 0.031, q.y - 1.648, 0.006, 0.007) ? kEye : kWhite;
    }
    if (in_ellipse(std::abs(q.x) - 0.031, q.y - 1.667, 0.018, 0.004)) return kHair;  // brows
    if (in_ellipse(q.x, q.y - 1.582, 0.024, 0.007)) return kLip;
  }
  return kSkin;
}

/// Stripes on the figure's left side, plain on its right; a disc on the left of the chest and a
/// slanting bar on the right of the back.
glm::u8vec3 shirt(const glm::dvec3& q) {
  if (q.y > 1.415 && in_ellipse(q.x, q.z + 0.015, 0.078, 0.075)) return kSkin;  // the neckline
  if (q.z > 0.0 && in_ellipse(q.x - 0.075, q.y - 1.33, 0.036, 0.036)) return kYellow;
  if (q.z < 0.0 && q.x < -0.02 && std::abs(q.y - 1.25 - 1.2 * (q.x + 0.08)) < 0.035) {
    return kYellow;
  }
  if (q.x <= 0.0) return kNavy;
  const double stripe = q.y / 0.06;
  return stripe - std::floor(stripe) < 0.5 ? kTeal : kWhite;
}

bool in_band(double x, double half) { return std::abs(x) < half; }

/// The pattern of a truncated icosahedron: the colour of the face that the direction n points at.
glm::u8vec3 soccer_ball(const glm::dvec3& n) {
  constexpr double kGolden = 1.6180339887498949, kPentagon = 2.32744, kHexagon = 2.26728;
  const double vertex_length = std::sqrt(1.0 + kGolden * kGolden), face_length = std::sqrt(3.0);
  const glm::dvec3 a = glm::abs(n);
  double pentagon = 0.0, first = 0.0, second = 0.0;
  const auto face = [&](double along, double height) {
    const double exit = along / height;
    second = std::max(second, std::min(first, exit));
    first = std::max(first, exit);
    return exit;
  };
  for (int i = 0; i < 3; ++i) {
    const double x = a[i], y = a[(i + 1) % 3], z = a[(i + 2) % 3];
    // The corners (0, 1, golden) of an icosahedron and two kinds of corners of a dodecahedron.
    // Corners with other signs are no nearer than their mirror images, so they matter at most for a
    // seam.
    pentagon = std::max(pentagon, face((x + kGolden * y) / vertex_length, kPentagon));
    pentagon = std::max(pentagon, face((kGolden * y - x) / vertex_length, kPentagon));
    face((y / kGolden + kGolden * z) / face_length, kHexagon);
    face((kGolden * z - y / kGolden) / face_length, kHexagon);
  }
  face((a.x + a.y + a.z) / face_length, kHexagon);
  if (pentagon >= first) return {28, 28, 30};
  return first - second < 0.006 ? glm::u8vec3{120, 120, 118} : kWhite;
}

/// Two great circles and two arcs: the seams between the eight panels of a basketball.
glm::u8vec3 basketball(const glm::dvec3& n) {
  constexpr double kSeam = 0.028;
  const bool seam = in_band(n.x, kSeam) || in_band(n.y, kSeam) ||
                    in_band(std::abs(n.x) - 0.45 - 0.32 * n.y * n.y, kSeam);
  return seam ? glm::u8vec3{34, 26, 24} : glm::u8vec3{206, 98, 42};
}

/// The seam y^2 - x^2 = k z divides the ball into two halves of the same shape.
glm::u8vec3 baseball(const glm::dvec3& n) {
  return in_band(n.y * n.y - n.x * n.x - 0.45 * n.z, 0.1) ? kRed : kWhite;
}

glm::u8vec3 bat(const glm::dvec3& q) {
  if (q.y < 0.28) return {44, 40, 40};                       // the grip's tape
  if (q.y > 0.56 && q.y < 0.6) return {120, 40, 32};         // a ring
  const double ring = q.y * 3.0 + 40.0 * q.x * (1.0 + q.z);  // the grain
  return ring - std::floor(ring) < 0.3 ? glm::u8vec3{196, 150, 92} : glm::u8vec3{214, 172, 112};
}

/// The colour without the texture.
glm::u8vec3 plain_color(Material material, const glm::dvec3& q) {
  const bool left = q.x > 0.0;
  switch (material) {
    case Material::skin:
      return kSkin;
    case Material::head:
      return face(q);
    case Material::hair:
      return kHair;
    case Material::shirt:
      return shirt(q);
    case Material::trim:
      return kWhite;
    case Material::pelvis:
      if (q.y > 1.035) return shirt(q);
      return q.y > 1.005 ? kBelt : kDenim;
    case Material::sleeve:
      if (q.y < 1.22) return kSkin;
      if (q.y < 1.25) return kWhite;  // the hem
      return left ? kRed : kNavy;
    case Material::trousers:
      if (q.y < 0.125) return kSkin;
      // A stripe down the outside of the right leg.
      return !left && q.x < -0.1 && std::abs(q.z) < 0.016 ? kWhite : kDenim;
    case Material::shoe:
      if (q.y < 0.016) return kSoleWhite;
      return left ? kRed : kShoe;
    case Material::soccer_ball:
      return soccer_ball(q / radius(Ball::Kind::soccer));
    case Material::basketball:
      return basketball(q / radius(Ball::Kind::basketball));
    case Material::baseball:
      return baseball(q / radius(Ball::Kind::baseball));
    case Material::bat:
      return bat(q);
  }
  return kSkin;
}

/// How much lighter (positive) or darker (negative) than its plain colour the material is at q, as
/// a share of about -1 to 1.
double texture(Material material, const glm::dvec3& q) {
  switch (material) {
    case Material::skin:
    case Material::head:
      return 0.05 * value_noise(q / 0.012, 1) + 0.03 * value_noise(q / 0.003, 2);
    case Material::hair:  // strands
      return 0.35 * value_noise(q / glm::dvec3(0.004, 0.03, 0.004), 3) +
             0.1 * value_noise(q / 0.02, 4);
    case Material::shirt:
    case Material::sleeve:
    case Material::trim:
      return 0.06 * value_noise(q / 0.045, 5) + 0.05 * weave(q, 0.006) +
             0.03 * value_noise(q / 0.002, 6);
    case Material::pelvis:
    case Material::trousers:  // denim with worn patches and coarse threads
      return 0.14 * value_noise(q / 0.07, 7) + 0.09 * weave(q, 0.008) +
             0.06 * value_noise(q / glm::dvec3(0.003, 0.012, 0.003), 8);
    case Material::shoe:
      return 0.1 * value_noise(q / 0.02, 9) + 0.06 * value_noise(q / 0.004, 10);
    case Material::soccer_ball:
    case Material::basketball:
    case Material::baseball:
      return 0.04 * value_noise(q / 0.03, 11) + 0.05 * value_noise(q / 0.003, 12);
    case Material::bat:  // the grain of the wood
      return 0.12 * value_noise(q / glm::dvec3(0.004, 0.12, 0.004), 13);
  }
  return 0.0;
}

}  // namespace

glm::u8vec3 color_at(const Body& body, std::size_t primitive, const glm::dvec3& p) {
  const Material material = body.parts[primitive].material;
  const glm::dvec3 q = body.in_rest(primitive, p);
  return shaded(plain_color(material, q), texture(material, q));
}

}  // namespace pointreel
