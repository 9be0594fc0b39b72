#include "client/render/instances.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include <glm/gtc/packing.hpp>

#include "client/render/srgb.h"
#include "common/base/for_each.h"

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

/// The radius of points in spacings between neighbours. With 1, scanned curves still show what is
/// behind them; more than this widens outlines.
constexpr float kCover = 1.25f;

/// The half edge of points in radii of surfels, which leave gaps between uneven neighbours. Surfels
/// are enlarged by as much (SplatScales).
constexpr float kPointScale = 1.4f;

float scale_of(DrawMode mode) { return mode == DrawMode::point ? kPointScale : 1.0f; }

/// The colour of every element with ColorSource::plain, and of those without one, sRGB.
constexpr glm::u16vec3 kPlain(0xd0d0);

glm::u16vec3 color_of(ColorSource source, const std::vector<glm::u16vec3>& colors, std::size_t i,
                      const glm::i16vec4& normal) {
  if (source == ColorSource::normals) return fake_color(normal);
  // Other colours than these are found for each pixel (shading.h).
  return source != ColorSource::colors || colors.empty() ? kPlain : colors[i];
}

/// Bit a is set if coordinate a of the eye is higher than that of the centre.
unsigned octant_of(const glm::vec3& eye, const glm::vec3& center) {
  return (eye.x > center.x ? 1u : 0u) | (eye.y > center.y ? 2u : 0u) | (eye.z > center.z ? 4u : 0u);
}

/// Packs the elements from 0 to `count` that are kept, in their order, block by block: make(i)
/// returns the instance of one. `keeps_all` saves asking keeps(i).
template <class Keeps, class Make>
std::size_t pack(std::size_t count, bool keeps_all, const Keeps& keeps, const Make& make,
                 std::span<Instance> out, InstanceBounds& bounds, const Executor& executor) {
  constexpr std::size_t kBlock = 16384;
  const auto blocks = static_cast<int>((count + kBlock - 1) / kBlock);
  const auto range = [count](int block) {
    const std::size_t begin = static_cast<std::size_t>(block) * kBlock;
    return std::pair(begin, std::min(begin + kBlock, count));
  };
  std::vector<std::size_t> first(static_cast<std::size_t>(blocks) + 1);
  for_each(executor, blocks, [&](int block) {
    const auto [begin, end] = range(block);
    std::size_t kept = end - begin;
    if (!keeps_all) {
      kept = 0;
      for (std::size_t i = begin; i < end; ++i) kept += keeps(i) ? 1 : 0;
    }
    first[static_cast<std::size_t>(block) + 1] = kept;
  });
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<InstanceBounds> parts(static_cast<std::size_t>(blocks));
  for_each(executor, blocks, [&](int block) {
    const auto [begin, end] = range(block);
    std::size_t to = first[static_cast<std::size_t>(block)];
    InstanceBounds part;
    for (std::size_t i = begin; i < end; ++i) {
      if (!keeps_all && !keeps(i)) continue;
      const Instance one = make(i);
      out[to++] = one;
      part.grow(one.center, one.radius);
    }
    parts[static_cast<std::size_t>(block)] = part;
  });
  for (const InstanceBounds& part : parts) bounds.grow(part);
  return first.back();
}

}  // namespace

bool shows_own_colors(const SceneFrame& frame, ColorSource color) {
  return color == ColorSource::colors && !frame.scalar &&
         (frame.cloud.has_colors() || !frame.attributes.colors.empty());
}

glm::u16vec3 fake_color(const glm::i16vec4& normal) {
  return glm::u16vec3(glm::ivec3(normal) + 32767);
}

std::size_t pack_points(const SceneFrame& frame, const ElementStyle& style, const glm::vec3& offset,
                        const std::vector<bool>& divided, std::span<Instance> out,
                        InstanceBounds& bounds, const Executor& executor) {
  const PointCloud& cloud = frame.cloud;
  const float scale = scale_of(style.mode);
  const float leaf_radius =
      static_cast<float>(0.5 * std::sqrt(3.0) * frame.svo.cell_size(frame.svo.depth));
  const auto make = [&](std::size_t i) -> Instance {
    const glm::i16vec4 normal =
        cloud.has_normals() ? pack_normal(cloud.normals[i]) : glm::i16vec4(0);
    const float radius = scale * (frame.spacing > 0.0f ? kCover * frame.spacing
                                  : cloud.has_radii()  ? cloud.radii[i]
                                                       : leaf_radius);
    return {cloud.positions[i] + offset, radius, normal,
            pack_color(color_of(style.color, cloud.colors, i, normal))};
  };
  return pack(
      cloud.size(), divided.empty(), [&](std::size_t i) { return !divided[i]; }, make, out, bounds,
      executor);
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

Instance pack_representative(const SceneFrame& frame, const StripNode& node, ColorSource color,
                             const glm::vec3& offset) {
  const glm::i16vec4 normal(node.normal, 0);
  const bool plain = color == ColorSource::plain || !frame.cloud.has_colors();
  const glm::u16vec3 shown = color == ColorSource::normals ? fake_color(normal)
                             : plain                       ? kPlain
                                                           : node.color;
  return {node.position + offset, 0.0f, normal, pack_color(shown)};
}

std::size_t pack_nodes(const SceneFrame& frame, std::span<const CutNode> cut,
                       const ElementStyle& style, const glm::vec3& eye, const glm::vec3& offset,
                       const std::vector<bool>& divided, std::span<Instance> out,
                       InstanceBounds& bounds, const Executor& executor) {
  const NodeAttributes& attributes = frame.attributes;
  const float scale = scale_of(style.mode);
  const bool halves = style.mode == DrawMode::voxel || frame.radii.empty();
  const bool unfilled = !style.fill_holes && !frame.filled.empty();
  // Voxels that fill gaps would hide others although they are not drawn.
  const bool hiding = style.mode == DrawMode::voxel && !frame.neighbors.empty() && !unfilled;
  const bool on_surface = style.mode == DrawMode::surfel && !frame.heights.empty();
  const std::uint32_t first_leaf = frame.svo.node_count() - frame.svo.leaf_count();
  const auto keeps = [&](std::size_t i) {
    const CutNode& node = cut[i];
    if (unfilled && frame.filled[node.node]) return false;
    if (node.node < first_leaf) return true;
    if (!divided.empty() && divided[node.node - first_leaf]) return false;
    return !hiding || !hidden(frame.neighbors[node.node - first_leaf], octant_of(eye, node.center));
  };
  const auto make = [&](std::size_t i) -> Instance {
    const CutNode& node = cut[i];
    const glm::i16vec4 normal = attributes.normals.empty()
                                    ? glm::i16vec4(0)
                                    : glm::i16vec4(attributes.normals[node.node], 0);
    glm::vec3 center = node.center + offset;
    if (on_surface && node.node >= first_leaf)
      center += frame.heights[node.node - first_leaf] / 32767.0f * glm::vec3(normal);
    const float radius =
        scale * (halves ? std::max(node.half, kCover * frame.spacing) : frame.radii[node.node]);
    return {center, radius, normal,
            pack_color(color_of(style.color, attributes.colors, node.node, normal))};
  };
  return pack(cut.size(), !unfilled && divided.empty() && !hiding, keeps, make, out, bounds,
              executor);
}

}  // namespace pointreel
