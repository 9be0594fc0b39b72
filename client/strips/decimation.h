#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "client/strips/patches.h"
#include "client/strips/stripping_tree.h"
#include "client/strips/surfels.h"

namespace pointreel {

/// Takes those triangles out of patches that others make up for. Neighbouring patches overlap at
/// their borders, and mostly agree there. The classes are those of Boubekeur, Reuter and Schlick,
/// "Surfel Stripping", 2005, section 3.2, but for the third, of which theirs, dual pairs, are one
/// case:
///
/// - outer triangles, without a corner in the patch, are not among its triangles any more;
/// - redundant: an earlier patch has the same triangle;
/// - covered: triangles of earlier patches that share a corner with this one lie over all of it;
/// - valid: all others, and these stay.
///
/// The paper compares a patch with those "generated so far". Comparing it with the triangles that
/// all earlier patches had before any were taken out gives the same surface in any order, and so
/// on any number of threads.
class Decimation {
 public:
  Decimation(const StripSurfels& surfels, const StrippingTree& tree, const Patches& patches)
      : surfels_(surfels), tree_(tree), patches_(patches) {}

  /// Appends the corners of the triangles of a patch that stay.
  void run(std::uint32_t patch, std::vector<std::array<std::uint32_t, 3>>& out);

 private:
  /// The earlier patches that own a corner of a triangle.
  void find_rivals(std::uint32_t patch, const PatchTriangle& triangle);
  bool redundant(const PatchTriangle& triangle) const;
  bool covered(const PatchTriangle& triangle) const;

  const StripSurfels& surfels_;
  const StrippingTree& tree_;
  const Patches& patches_;
  std::vector<std::uint32_t> rivals_;
};

}  // namespace pointreel
