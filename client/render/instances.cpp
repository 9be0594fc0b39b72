#include "client/render/instances.h"

#include <cmath>

namespace pointreel {
namespace {

glm::i16vec4 pack_normal(const glm::vec3& n) {
  // Not normalised here: sanitize and the estimators keep normals at unit length or zero. What is
  // neither, a NaN above all, counts as unknown.
  const float l2 = glm::dot(n, n);
  if (!(l2 > 0.5f && l2 < 2.0f)) return glm::i16vec4(0);
  const glm::vec3 scaled = glm::clamp(n * 32767.0f, -32767.0f, 32767.0f);
  return {static_cast<std::int16_t>(std::lrint(scaled.x)),
          static_cast<std::int16_t>(std::lrint(scaled.y)),
          static_cast<std::int16_t>(std::lrint(scaled.z)), 0};
}

std::uint8_t eight_bits(unsigned sixteen) {
  return static_cast<std::uint8_t>((sixteen + 128u) / 257u);
}

glm::u8vec4 pack_color(const glm::u16vec3& c) {
  return {eight_bits(c.x), eight_bits(c.y), eight_bits(c.z), 255};
}

}  // namespace

glm::u8vec3 fake_color(const glm::i16vec4& normal) {
  const auto channel = [](int n) {
    return static_cast<std::uint8_t>((n + 32767) * 255 / (2 * 32767));
  };
  return {channel(normal.x), channel(normal.y), channel(normal.z)};
}

void pack_points(const SceneFrame& frame, std::span<Instance> out) {
  const PointCloud& cloud = frame.cloud;
  const float leaf_radius =
      static_cast<float>(0.5 * std::sqrt(3.0) * frame.svo.cell_size(frame.svo.depth));
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::i16vec4 normal =
        cloud.has_normals() ? pack_normal(cloud.normals[i]) : glm::i16vec4(0);
    out[i] = {
        cloud.positions[i], cloud.has_radii() ? cloud.radii[i] : leaf_radius, normal,
        cloud.has_colors() ? pack_color(cloud.colors[i]) : glm::u8vec4(fake_color(normal), 255), 0};
  }
}

void pack_voxels(const SceneFrame& frame, std::span<const CutNode> cut, std::span<Instance> out) {
  const NodeAttributes& attributes = frame.attributes;
  for (std::size_t i = 0; i < cut.size(); ++i) {
    const CutNode& node = cut[i];
    const glm::i16vec4 normal = attributes.normals.empty()
                                    ? glm::i16vec4(0)
                                    : glm::i16vec4(attributes.normals[node.node], 0);
    out[i] = {node.center, node.half, normal,
              attributes.colors.empty() ? glm::u8vec4(fake_color(normal), 255)
                                        : pack_color(attributes.colors[node.node]),
              0};
  }
}

}  // namespace pointreel
