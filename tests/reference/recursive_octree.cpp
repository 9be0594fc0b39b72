#include "tests/reference/recursive_octree.h"

#include <utility>

namespace pointreel::reference {

RecursiveOctree::RecursiveOctree(const PointCloud& cloud, const Cube& cube, double delta,
                                 int max_depth) {
  if (cloud.empty()) return;
  const double half = 0.5 * cube.edge;
  auto* root = new Node{cube.origin + half, half, {}, {}};
  for (std::size_t i = 0; i < cloud.size(); ++i) root->points.push_back(cloud.world(i));
  all_.push_back(root);
  leaves_.push_back(root);

  const double n = static_cast<double>(cloud.size());
  while (depth_ < max_depth && static_cast<double>(leaves_.size()) / n < 1.0 - delta) {
    std::vector<Node*> next;
    for (Node* leaf : leaves_) subdivide(*leaf, next);
    leaves_ = std::move(next);
    ++depth_;
  }
}

RecursiveOctree::~RecursiveOctree() {
  for (Node* node : all_) delete node;
}

void RecursiveOctree::subdivide(Node& node, std::vector<Node*>& children) {
  for (const glm::dvec3& p : node.points) {
    const int octant = (p.x >= node.center.x ? 1 : 0) + (p.y >= node.center.y ? 2 : 0) +
                       (p.z >= node.center.z ? 4 : 0);
    Node*& child = node.children[octant];
    if (child == nullptr) {
      const double half = 0.5 * node.half;
      const glm::dvec3 side(octant & 1 ? half : -half, octant & 2 ? half : -half,
                            octant & 4 ? half : -half);
      child = new Node{node.center + side, half, {}, {}};
      all_.push_back(child);
    }
    child->points.push_back(p);
  }
  node.points.clear();
  node.points.shrink_to_fit();
  for (Node* child : node.children) {
    if (child != nullptr) children.push_back(child);
  }
}

std::size_t RecursiveOctree::node_count() const { return all_.size(); }

std::vector<std::uint8_t> RecursiveOctree::masks() const {
  std::vector<std::uint8_t> masks;
  std::vector<const Node*> level;
  if (!all_.empty()) level.push_back(all_.front());
  for (int l = 0; l < depth_; ++l) {
    std::vector<const Node*> next;
    for (const Node* node : level) {
      std::uint8_t mask = 0;
      for (int c = 0; c < 8; ++c) {
        if (node->children[c] == nullptr) continue;
        mask = static_cast<std::uint8_t>(mask | 1 << c);
        next.push_back(node->children[c]);
      }
      masks.push_back(mask);
    }
    level = std::move(next);
  }
  return masks;
}

}  // namespace pointreel::reference
