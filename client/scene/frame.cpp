#include "client/scene/frame.h"

namespace pointreel {

namespace {

template <class Element>
std::uint64_t memory_of(const std::vector<Element>& elements) {
  return elements.capacity() * sizeof(Element);
}

}  // namespace

PointCloud surfels_of(const SceneFrame& frame) {
  if (!frame.cloud.empty()) return frame.cloud;
  const NodeAttributes& attributes = frame.attributes;
  const auto first = static_cast<std::ptrdiff_t>(frame.svo.node_count() - frame.svo.leaf_count());
  PointCloud surfels = leaf_centers(frame.svo);
  if (!attributes.colors.empty())
    surfels.colors.assign(attributes.colors.begin() + first, attributes.colors.end());
  if (!frame.radii.empty()) surfels.radii.assign(frame.radii.begin() + first, frame.radii.end());
  for (auto normal = attributes.normals.begin() + (attributes.normals.empty() ? 0 : first);
       normal != attributes.normals.end(); ++normal)
    surfels.normals.push_back(glm::vec3(*normal) / 32767.0f);
  for (std::size_t i = 0; i < frame.heights.size(); ++i)
    surfels.positions[i] += frame.heights[i] * surfels.normals[i];
  return surfels;
}

std::uint64_t memory_of(const SceneFrame& frame) {
  const PointCloud& cloud = frame.cloud;
  return sizeof(SceneFrame) + memory_of(cloud.positions) + memory_of(cloud.normals) +
         memory_of(cloud.colors) + memory_of(cloud.radii) + memory_of(frame.strips.nodes) +
         memory_of(frame.strips.indices) + memory_of(frame.svo.level_begin) +
         memory_of(frame.svo.masks) + memory_of(frame.svo.first_child) +
         memory_of(frame.attributes.colors) + memory_of(frame.attributes.normals) +
         memory_of(frame.radii) + memory_of(frame.heights) + frame.filled.capacity() / 8 +
         memory_of(frame.neighbors);
}

}  // namespace pointreel
