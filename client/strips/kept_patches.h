#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "client/strips/patches.h"
#include "client/strips/stripping_tree.h"
#include "client/strips/surfel_changes.h"
#include "client/strips/surfels.h"
#include "pointreel/executor.h"

namespace pointreel {

struct StripRecord;

/// Which patches are the same as in a record, with all surfels that are triangulated with them.
/// Indices of surfels of a record become those of now in their order, because both follow the
/// cells. That is why what depends on that order is the same, too.
class KeptPatches {
 public:
  /// The record was made by the same rules. Everything given outlives this.
  KeptPatches(const StripRecord& record, SurfelChanges changes, const StripSurfels& surfels,
              const StrippingTree& tree, const InflationRule& rule, const Executor& executor);

  /// Appends the triangles that a patch had if it is kept; otherwise returns false.
  bool append_triangles(std::size_t patch, std::vector<PatchTriangle>& out) const;
  /// Whether the strips of a patch are the same: it is kept, and so are all earlier patches that
  /// share triangles with it.
  bool same_strips(std::size_t patch, const Patches& patches) const;
  /// The patch of the record that a patch was, if it is kept.
  std::uint32_t patch_before(std::size_t patch) const { return before_[patch]; }
  std::uint32_t surfel_now(std::uint32_t before) const { return changes_.surfel_now(before); }

 private:
  std::uint32_t find(const PatchNode& patch, const StripSurfels& surfels,
                     const InflationRule& rule) const;

  static constexpr std::uint32_t kNotKept = ~std::uint32_t{0};

  const StripRecord& record_;
  const StrippingTree& tree_;
  SurfelChanges changes_;
  std::vector<std::uint32_t> before_;
};

}  // namespace pointreel
