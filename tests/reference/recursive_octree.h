#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "pointreel/cloud.h"

namespace pointreel::reference {

/// The octree of Slomp et al., Geometry Instancing, section VI-A, as the paper describes it: nodes
/// own their points and children, and are divided level by level while oct(h) / n < 1 - delta. It
/// is slow and obviously correct; the fast build is tested and timed against it.
class RecursiveOctree {
 public:
  RecursiveOctree(const PointCloud& cloud, const Cube& cube, double delta, int max_depth);
  ~RecursiveOctree();
  RecursiveOctree(const RecursiveOctree&) = delete;
  RecursiveOctree& operator=(const RecursiveOctree&) = delete;

  int depth() const { return depth_; }
  std::size_t node_count() const;  ///< including leaves
  std::size_t leaf_count() const { return leaves_.size(); }

  /// One mask for each internal node, breadth-first.
  std::vector<std::uint8_t> masks() const;

 private:
  struct Node {
    glm::dvec3 center;
    double half;
    std::vector<glm::dvec3> points;
    Node* children[8] = {};
  };

  void subdivide(Node& node, std::vector<Node*>& children);

  std::vector<Node*> all_;
  std::vector<Node*> leaves_;
  int depth_ = 0;
};

}  // namespace pointreel::reference
