#include "client/scene/frame.h"

namespace pointreel {

namespace {

template <class Element>
std::uint64_t memory_of(const std::vector<Element>& elements) {
  return elements.capacity() * sizeof(Element);
}

}  // namespace

std::uint64_t memory_of(const SceneFrame& frame) {
  const PointCloud& cloud = frame.cloud;
  return sizeof(SceneFrame) + memory_of(cloud.positions) + memory_of(cloud.normals) +
         memory_of(cloud.colors) + memory_of(cloud.radii) + memory_of(frame.svo.level_begin) +
         memory_of(frame.svo.masks) + memory_of(frame.svo.first_child) +
         memory_of(frame.attributes.colors) + memory_of(frame.attributes.normals) +
         memory_of(frame.radii) + frame.filled.capacity() / 8 + memory_of(frame.neighbors);
}

}  // namespace pointreel
