#include "client/render/light_probe.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace pointreel {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;

/// Environments are reduced to about this size first: what follows looks at every pair of texels.
constexpr int kHeight = 32;
/// What is brighter than the mean by this factor becomes the key light.
constexpr float kKeyLight = 8.0f;
/// The light that a white surface returns that faces the key light, without highlights.
constexpr float kBrightest = 0.9f;

float luminance(const glm::vec3& c) { return glm::dot(c, glm::vec3(0.2126f, 0.7152f, 0.0722f)); }

/// The polynomials of LightProbe::diffuse.
std::array<float, 9> polynomials(const glm::vec3& n) {
  return {1.0f,
          n.y,
          n.z,
          n.x,
          n.x * n.y,
          n.y * n.z,
          3.0f * n.z * n.z - 1.0f,
          n.x * n.z,
          n.x * n.x - n.y * n.y};
}

/// The squares of the factors that make the polynomials orthonormal, times the share of each band
/// that remains in the light that diffuse surfaces return: 1, 2/3, 1/4.
constexpr std::array<float, 9> kWeights = {0.0795775f,  0.1591549f, 0.1591549f,
                                           0.1591549f,  0.2984155f, 0.2984155f,
                                           0.02486796f, 0.2984155f, 0.07460388f};

/// Means over squares of texels, weighted by solid angles.
EnvironmentMap reduced(const EnvironmentMap& map) {
  const int edge = std::max(1, map.height / kHeight);
  EnvironmentMap out{(map.width + edge - 1) / edge, (map.height + edge - 1) / edge, {}};
  out.texels.resize(static_cast<std::size_t>(out.width) * static_cast<std::size_t>(out.height));
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      glm::vec3 sum(0.0f);
      float weights = 0.0f;
      for (int j = y * edge; j < std::min((y + 1) * edge, map.height); ++j) {
        const float weight = solid_angle_of_texel(map, j);
        for (int i = x * edge; i < std::min((x + 1) * edge, map.width); ++i) {
          sum += weight * map.at(i, j);
          weights += weight;
        }
      }
      out.at(x, y) = sum / weights;
    }
  return out;
}

/// The direction of a texel of an octahedral map, which may be one outside of it.
glm::vec3 octahedral_direction(int x, int y) {
  constexpr int kEdge = LightProbe::kGlossyEdge;
  // Beyond an edge, the map goes on with the texels beside the same edge, in reverse order.
  if (x < 0 || x >= kEdge) {
    x = std::clamp(x, 0, kEdge - 1);
    y = kEdge - 1 - y;
  }
  if (y < 0 || y >= kEdge) {
    y = std::clamp(y, 0, kEdge - 1);
    x = kEdge - 1 - x;
  }
  glm::vec2 p((2.0f * (static_cast<float>(x) + 0.5f) / kEdge) - 1.0f,
              (2.0f * (static_cast<float>(y) + 0.5f) / kEdge) - 1.0f);
  const float up = 1.0f - std::abs(p.x) - std::abs(p.y);
  if (up < 0.0f)
    p = glm::vec2(p.x < 0.0f ? -1.0f : 1.0f, p.y < 0.0f ? -1.0f : 1.0f) *
        (1.0f - glm::vec2(std::abs(p.y), std::abs(p.x)));
  return glm::normalize(glm::vec3(p.x, up, p.y));
}

}  // namespace

LightProbe make_light_probe(const EnvironmentMap& map, float roughness) {
  EnvironmentMap small = reduced(map);
  LightProbe probe;
  struct Sample {
    glm::vec3 direction;
    float solid_angle;
    glm::vec3 light;
  };
  std::vector<Sample> samples;
  glm::vec3 all(0.0f);
  for (int y = 0; y < small.height; ++y)
    for (int x = 0; x < small.width; ++x) {
      samples.push_back(
          {direction_of_texel(small, x, y), solid_angle_of_texel(small, y), small.at(x, y)});
      all += samples.back().solid_angle * samples.back().light;
    }
  const float most = kKeyLight * luminance(all) / (4.0f * kPi);
  glm::vec3 towards(0.0f);
  for (Sample& sample : samples) {
    const float light = luminance(sample.light);
    if (!(light > most)) continue;
    const glm::vec3 more = sample.solid_angle * (1.0f - most / light) * sample.light;
    towards += luminance(more) * sample.direction;
    probe.key += more / kPi;
    sample.light *= most / light;
  }
  if (glm::dot(towards, towards) > 0.0f) probe.key_direction = glm::normalize(towards);
  for (const Sample& sample : samples) {
    const auto values = polynomials(sample.direction);
    for (std::size_t i = 0; i < 9; ++i)
      probe.diffuse[i] += kWeights[i] * values[i] * sample.solid_angle * sample.light;
  }

  constexpr int kEdge = LightProbe::kGlossyEdge;
  const float alpha2 = roughness * roughness * roughness * roughness;
  for (int y = -1; y <= kEdge; ++y)
    for (int x = -1; x <= kEdge; ++x) {
      const glm::vec3 mirrored = octahedral_direction(x, y);
      glm::vec3 sum(0.0f);
      float weights = 0.0f;
      for (const Sample& sample : samples) {
        const float cosine = glm::dot(mirrored, sample.direction);
        if (!(cosine > 0.0f)) continue;
        // The half vector between the normal, from where the eye looks, and the light.
        const float half2 = 0.5f + 0.5f * cosine;
        const float base = half2 * (alpha2 - 1.0f) + 1.0f;
        const float weight = sample.solid_angle * cosine / (base * base);
        sum += weight * sample.light;
        weights += weight;
      }
      probe.glossy.push_back(sum / std::max(weights, 1e-20f));
    }

  // The brightest that a white surface can be.
  const auto values = polynomials(probe.key_direction);
  glm::vec3 brightest = probe.key;
  for (std::size_t i = 0; i < 9; ++i) brightest += probe.diffuse[i] * values[i];
  const float factor = kBrightest / std::max(luminance(brightest), 1e-20f);
  for (glm::vec3& c : probe.diffuse) c *= factor;
  for (glm::vec3& c : probe.glossy) c *= factor;
  probe.key *= factor;
  return probe;
}

const LightProbe& LightProbes::probe(const DrawOptions& options) {
  Key key{options.light == Light::environment ? options.environment : nullptr, options.roughness};
  if (key_ != key) {
    probe_ =
        make_light_probe(key.environment ? *key.environment : studio_environment(), key.roughness);
    key_ = std::move(key);
  }
  return probe_;
}

}  // namespace pointreel
