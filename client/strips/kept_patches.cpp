#include "client/strips/kept_patches.h"

#include <algorithm>
#include <span>
#include <utility>

#include "client/strips/strip_record.h"
#include "common/base/for_each.h"

namespace pointreel {
namespace {

/// Patches that are looked for by one call of the executor.
constexpr std::size_t kBlock = 256;

}  // namespace

KeptPatches::KeptPatches(const StripRecord& record, SurfelChanges changes,
                         const StripSurfels& surfels, const StrippingTree& tree,
                         const InflationRule& rule, const Executor& executor)
    : record_(record),
      tree_(tree),
      changes_(std::move(changes)),
      before_(tree.patches.size(), kNotKept) {
  for_each(executor, static_cast<int>((before_.size() + kBlock - 1) / kBlock), [&](int block) {
    const std::size_t begin = static_cast<std::size_t>(block) * kBlock;
    for (std::size_t i = begin; i < std::min(begin + kBlock, before_.size()); ++i)
      before_[i] = find(tree.nodes[tree.patches[i]], surfels, rule);
  });
}

std::uint32_t KeptPatches::find(const PatchNode& patch, const StripSurfels& surfels,
                                const InflationRule& rule) const {
  if (!changes_.same(patch.svo_node)) return kNotKept;
  const StrippingTree& old_tree = record_.tree;
  const std::uint32_t node_before = changes_.node_before(patch.svo_node);
  const std::uint32_t found = old_tree.patch_of[old_tree.first_surfel[node_before]];
  const PatchNode& old_patch = old_tree.nodes[old_tree.patches[found]];
  if (old_patch.level != patch.level) return kNotKept;
  // Since the surfels are the same, they reach as far as they did.
  const float reach = inflation_reach(surfels, patch, rule);
  const PatchNode& node = node_of_reach(surfels.svo, tree_, patch, reach);
  const PatchNode& old_node = node_of_reach(record_.svo, old_tree, old_patch, reach);
  for (std::size_t i = 0; i < node.around.size(); ++i) {
    const std::uint32_t around = node.around[i], old_around = old_node.around[i];
    if (around == kNoNode ? old_around != kNoNode : !changes_.same(around)) return kNotKept;
  }
  return found;
}

bool KeptPatches::append_triangles(std::size_t patch, std::vector<PatchTriangle>& out) const {
  if (before_[patch] == kNotKept) return false;
  const std::span<const PatchTriangle> triangles = record_.patches.triangles(before_[patch]);
  const std::size_t first = out.size();
  out.insert(out.end(), triangles.begin(), triangles.end());
  for (PatchTriangle& triangle : std::span(out).subspan(first))
    for (std::uint32_t& corner : triangle.corners) corner = surfel_now(corner);
  return true;
}

bool KeptPatches::same_strips(std::size_t patch, const Patches& patches) const {
  if (before_[patch] == kNotKept) return false;
  for (const PatchTriangle& triangle : patches.triangles(patch)) {
    if (triangle.inner) continue;
    for (const std::uint32_t corner : triangle.corners) {
      // Cells are in the same order in both trees, so that a later patch was not an earlier one.
      const std::uint32_t owner = tree_.patch_of[corner];
      if (owner < patch && before_[owner] == kNotKept) return false;
    }
  }
  return true;
}

}  // namespace pointreel
