#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include <glm/glm.hpp>

#include "client/scene/draw_options.h"
#include "client/scene/environment_map.h"

namespace pointreel {

/// An environment as renderers use it. Directions are those of the environment. All light is
/// multiplied by one factor, so that a white surface that faces the light is about as bright as
/// white.
struct LightProbe {
  /// Edge of `glossy` without the texel around it on each side.
  static constexpr int kGlossyEdge = 32;

  /// The light that a white diffuse surface returns, without that of the key light, as spherical
  /// harmonics up to order 2 of its normal: R. Ramamoorthi, P. Hanrahan, "An Efficient
  /// Representation for Irradiance Environment Maps", 2001. The coefficients belong to the
  /// polynomials 1, y, z, x, xy, yz, 3 z^2 - 1, xz, x^2 - y^2.
  std::array<glm::vec3, 9> diffuse{};
  /// What is so much brighter than the rest that it casts shadows: the unit vector towards it, and
  /// the light that a white diffuse surface that faces it returns; black if there is none.
  glm::vec3 key_direction{0.0f, 1.0f, 0.0f}, key{0.0f};
  /// The mean light around directions, weighted as by highlights of a roughness (B. Karis, "Real
  /// Shading in Unreal Engine 4", 2013), also without the key light. An octahedral map with
  /// kGlossyEdge + 2 texels per side.
  std::vector<glm::vec3> glossy;
};

LightProbe make_light_probe(const EnvironmentMap& map, float roughness);

/// Keeps the probe of the last picture.
class LightProbes {
 public:
  /// That of a picture's light; its options do not have flat light.
  const LightProbe& probe(const DrawOptions& options);

 private:
  struct Key {
    std::shared_ptr<const EnvironmentMap> environment;  ///< null: the studio
    float roughness;
    bool operator==(const Key&) const = default;
  };
  std::optional<Key> key_;
  LightProbe probe_;
};

}  // namespace pointreel
