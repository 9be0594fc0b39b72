#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "codec/octree/attribute_value.h"
#include "codec/octree/frame_structure.h"

/// Gives the children of a level's nodes their base values, to which what is coded is added.
/// FORMAT.md, "Prediction".
namespace pointreel {

/// How an attribute is predicted.
struct PredictionRule {
  /// The classes of a node's gradient are multiples of this.
  std::int32_t gradient_unit = 1;
  /// Whether the gradient is that of all components, or of the first.
  bool all_components = false;
};

/// The contexts that follow from the neighbours of a node.
inline constexpr int kActivityClasses = 9, kGradientClasses = 5;

/// The class of how much there was to code in the node's parent, where neighbours do not count.
std::size_t own_activity_class(const Short4& value);

/// So many values behind those of a tree are written over.
inline constexpr std::size_t kRoomForValues = 8;

/// Gives the children the value of their parent. A single child also takes its activity; the
/// activity of others is 0. `values`: of all nodes, with room for more.
void inherit_values(const Svo& svo, int level, Short4* values);

/// Gives the children of nodes with two or more of them values that follow the neighbours of the
/// node, and whose mean is that of the node; a single child is as above.
class LevelPredictor {
 public:
  /// The level is predictable. `values`: of all nodes; those down to this level are set.
  /// `contexts`: receives, for each node with two children or more by its number in the level,
  /// gradient class * kActivityClasses + activity class. `planes`: all zero, and so again at the
  /// end; they can be kept from level to level.
  LevelPredictor(const FrameStructure& structure, int level, const PredictionRule& rule,
                 Short4* values, std::uint8_t* contexts, std::vector<Short4>& planes);

  /// Predicts all slices.
  void run();
  /// Predicts one slice of `every`, and calls visit(node) for each of its nodes with two children
  /// or more. Single children are left as they are.
  template <class Visit>
  void run_some(std::size_t every, Visit visit) {
    for (std::size_t slice = every / 2; slice + 1 < level_.by_z.slices.size(); slice += every) {
      predict_alone(slice);
      for (const BranchingNode& node : branching()) visit(node);
    }
  }

 private:
  struct Steps;

  std::span<const BranchingNode> branching() const;
  void predict_slice();
  void predict_alone(std::size_t slice);
  bool follows(std::size_t slice) const;
  void fill(Short4* plane, std::size_t slice);
  void clear(Short4* plane, std::size_t slice);
  std::uint8_t predict(const BranchingNode& node, const Short4* at, const Steps& steps);
  Int4 weighted_shift(const Int4& own, const Int4* expected, std::uint32_t first,
                      int children) const;
  int gradient_class(const Int4& range) const;

  const Svo& svo_;
  const LevelStructure& level_;
  bool unit_;
  const std::uint32_t* weights_;
  PredictionRule rule_;
  Short4* values_;
  std::uint32_t first_node_;
  std::uint8_t* contexts_;
  std::size_t slice_ = 0;
  Short4* planes_[3];  ///< below the slice, of the slice, and above
};

}  // namespace pointreel
