#include "client/render/instances.h"

#include <cmath>
#include <vector>

#include <glm/gtc/packing.hpp>

#include "client/render/srgb.h"

namespace pointreel {
namespace {

glm::i16vec4 pack_normal(const glm::vec3& n) {
  // sanitize and the estimators keep normals at unit length or zero. Anything else, above all a
  // NaN, counts as unknown.
  const float l2 = glm::dot(n, n);
  if (!(l2 > 0.5f && l2 < 2.0f)) return glm::i16vec4(0);
  const glm::vec3 scaled = glm::clamp(n * 32767.0f, -32767.0f, 32767.0f);
  return {static_cast<std::int16_t>(std::lrint(scaled.x)),
          static_cast<std::int16_t>(std::lrint(scaled.y)),
          static_cast<std::int16_t>(std::lrint(scaled.z)), 0};
}

/// Linear light, as half floats, for every 16-bit sRGB value.
std::vector<std::uint16_t> make_linear_table() {
  std::vector<std::uint16_t> table(65536);
  for (std::size_t i = 0; i < table.size(); ++i) {
    const double linear = linear_from_srgb(static_cast<double>(i) / 65535.0);
    table[i] = glm::packHalf1x16(static_cast<float>(linear));
  }
  return table;
}

glm::u16vec4 pack_color(const glm::u16vec3& c) {
  static const std::vector<std::uint16_t> kLinear = make_linear_table();
  return {kLinear[c.x], kLinear[c.y], kLinear[c.z], 0};
}

/// The colour of every element with ColorSource::plain, and of those without one, sRGB.
constexpr glm::u16vec3 kPlain(0xd0d0);

glm::u16vec3 color_of(ColorSource source, const std::vector<glm::u16vec3>& colors, std::size_t i,
                      const glm::i16vec4& normal) {
  if (source == ColorSource::normals) return fake_color(normal);
  return source == ColorSource::plain || colors.empty() ? kPlain : colors[i];
}

/// Bit a is set if coordinate a of the eye is higher than that of the centre.
unsigned octant_of(const glm::vec3& eye, const glm::vec3& center) {
  return (eye.x > center.x ? 1u : 0u) | (eye.y > center.y ? 2u : 0u) | (eye.z > center.z ? 4u : 0u);
}

}  // namespace

glm::u16vec3 fake_color(const glm::i16vec4& normal) {
  return glm::u16vec3(glm::ivec3(normal) + 32767);
}

std::size_t pack_points(const SceneFrame& frame, ColorSource color, const glm::vec3& offset,
                        const std::vector<bool>& divided, std::span<Instance> out,
                        InstanceBounds& bounds) {
  const PointCloud& cloud = frame.cloud;
  const float leaf_radius =
      static_cast<float>(0.5 * std::sqrt(3.0) * frame.svo.cell_size(frame.svo.depth));
  std::size_t count = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!divided.empty() && divided[i]) continue;
    const glm::i16vec4 normal =
        cloud.has_normals() ? pack_normal(cloud.normals[i]) : glm::i16vec4(0);
    const float radius = cloud.has_radii() ? cloud.radii[i] : leaf_radius;
    const glm::vec3 center = cloud.positions[i] + offset;
    out[count++] = {center, radius, normal, pack_color(color_of(color, cloud.colors, i, normal))};
    bounds.grow(center, radius);
  }
  return count;
}

void pack_refined(const SceneFrame& frame, std::span<const RefinedSurfel> surfels,
                  ColorSource color, const glm::vec3& offset, std::span<Instance> out,
                  InstanceBounds& bounds) {
  const bool colors = frame.cloud.has_colors() || !frame.attributes.colors.empty();
  const ColorSource source = color == ColorSource::colors && !colors ? ColorSource::plain : color;
  for (std::size_t i = 0; i < surfels.size(); ++i) {
    const RefinedSurfel& surfel = surfels[i];
    const glm::i16vec4 normal = pack_normal(surfel.normal);
    const glm::vec3 center = surfel.position + offset;
    const glm::u16vec3 shown = source == ColorSource::normals  ? fake_color(normal)
                               : source == ColorSource::colors ? surfel.color
                                                               : kPlain;
    out[i] = {center, surfel.radius, normal, pack_color(shown)};
    bounds.grow(center, surfel.of_divided);  // holes are as wide as between those
  }
}

std::size_t pack_nodes(const SceneFrame& frame, std::span<const CutNode> cut,
                       const ElementStyle& style, const glm::vec3& eye, const glm::vec3& offset,
                       const std::vector<bool>& divided, std::span<Instance> out,
                       InstanceBounds& bounds) {
  const NodeAttributes& attributes = frame.attributes;
  const bool halves = style.mode == DrawMode::voxel || frame.radii.empty();
  const bool unfilled = !style.fill_holes && !frame.filled.empty();
  // Voxels that fill gaps would hide others although they are not drawn.
  const bool hiding = style.mode == DrawMode::voxel && !frame.neighbors.empty() && !unfilled;
  const bool on_surface = style.mode == DrawMode::surfel && !frame.heights.empty();
  const std::uint32_t first_leaf = frame.svo.node_count() - frame.svo.leaf_count();
  std::size_t count = 0;
  for (const CutNode& node : cut) {
    if (unfilled && frame.filled[node.node]) continue;
    if (!divided.empty() && node.node >= first_leaf && divided[node.node - first_leaf]) continue;
    if (hiding && node.node >= first_leaf &&
        hidden(frame.neighbors[node.node - first_leaf], octant_of(eye, node.center)))
      continue;
    const glm::i16vec4 normal = attributes.normals.empty()
                                    ? glm::i16vec4(0)
                                    : glm::i16vec4(attributes.normals[node.node], 0);
    const float radius = halves ? node.half : frame.radii[node.node];
    glm::vec3 center = node.center + offset;
    if (on_surface && node.node >= first_leaf)
      center += frame.heights[node.node - first_leaf] / 32767.0f * glm::vec3(normal);
    out[count++] = {center, radius, normal,
                    pack_color(color_of(style.color, attributes.colors, node.node, normal))};
    bounds.grow(center, radius);
  }
  return count;
}

}  // namespace pointreel
