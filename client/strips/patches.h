#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "client/strips/stripping_tree.h"
#include "client/strips/surfels.h"
#include "pointreel/executor.h"

namespace pointreel {

/// A triangle of a patch, whose corners are surfels.
struct PatchTriangle {
  /// The lowest first, counterclockwise as seen along the patch's normal.
  std::array<std::uint32_t, 3> corners;
  bool inner;  ///< all its corners are the patch's own, so that no other patch has it

  friend bool operator==(const PatchTriangle&, const PatchTriangle&) = default;
};

/// How a patch is triangulated.
struct InflationRule {
  /// Surfels of other patches are added that are no farther from the box around a patch than this
  /// times the mean of its surfels' radii. (The paper: a quarter of the cell's diameter, which is
  /// little for cells with few surfels.)
  float distance = 2.0f;
  /// No edge is longer than this times the sum of the radii at its ends. Beyond it is a hole.
  float longest = 2.0f;
  /// Surfels of other patches are left out if the cosine between their normals and that of the
  /// patch is less: they lie on another side.
  float least_cosine = 0.1f;

  bool operator==(const InflationRule&) const = default;
};

class KeptPatches;

/// The lowest node above a patch, or the patch, that is large enough for all surfels that may be
/// triangulated with the patch to lie in the nodes around it. `reach`: how far they may be.
const PatchNode& node_of_reach(const Svo& svo, const StrippingTree& tree, const PatchNode& patch,
                               float reach);
/// How far surfels of other patches may be from the box around a patch (InflationRule::distance).
float inflation_reach(const StripSurfels& surfels, const PatchNode& patch,
                      const InflationRule& rule);

/// Triangles of all patches, before the redundant ones are taken out.
class Patches {
 public:
  Patches() = default;
  /// Triangulates each patch with surfels around it, and keeps the triangles that have a corner in
  /// the patch. Patches that are kept are not triangulated again.
  Patches(const StripSurfels& surfels, const StrippingTree& tree, const InflationRule& rule,
          const Executor& executor, const KeptPatches* kept = nullptr);

  std::size_t size() const { return patches_.size(); }
  /// The triangles of a patch, in the order of their corners.
  std::span<const PatchTriangle> triangles(std::size_t patch) const {
    const Range& range = patches_[patch];
    return std::span(blocks_[patch / kBlock]).subspan(range.begin, range.end - range.begin);
  }

 private:
  struct Range {
    std::uint32_t begin, end;  ///< within the block's triangles
  };
  /// Patches that are triangulated by one call of the executor.
  static constexpr std::size_t kBlock = 64;

  std::vector<Range> patches_;
  std::vector<std::vector<PatchTriangle>> blocks_;
};

}  // namespace pointreel
