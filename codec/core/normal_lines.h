#pragma once

#include <vector>

#include <glm/glm.hpp>

#include "codec/core/build.h"
#include "pointreel/octree.h"

namespace pointreel {

/// `mean_normals` for normals whose signs are unknown: the principal axis of the lines that they
/// lie on. A normal and its opposite count the same, so the signs of the points' normals change
/// nothing but the signs of the means, which follow the majority. The cloud has normals.
std::vector<glm::i16vec3> mean_normal_lines(const Svo& svo, const PointCloud& cloud,
                                            const SortedPoints& sorted,
                                            const Executor& executor = {});
/// The same for a cloud that holds exactly one point for each leaf, in the order of the leaves.
std::vector<glm::i16vec3> mean_normal_lines(const Svo& svo, const PointCloud& leaves,
                                            const Executor& executor = {});

}  // namespace pointreel
