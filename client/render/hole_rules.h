#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace pointreel::hole_rules {

// The numbers by which renderers fill the holes of splatted surfaces. opengl/reconstruction.h and
// FORMULAS.md, "Hole filling", say how.

/// Large clouds need the backs of only a part of their surfels: about this many backs are drawn,
/// and at least one surfel in kFewest keeps its back. Positions decide which, not the order of the
/// surfels, so that the picture does not depend on it. Fewer backs would have to be larger, which
/// would widen the outlines of dense clouds. What takes the place of a surfel that looks large
/// (refinement.h) is not counted: there is much of it, and the backs of those that stay as they are
/// would stick out.
inline constexpr std::size_t kBacks = 16384;
inline constexpr std::size_t kFewest = 4;
/// Half the edge of a back in its radii if all backs are drawn. Smaller backs leave holes between
/// the curves of a scanner, larger ones widen outlines.
inline constexpr float kReach = 1.2f;
/// How far backs are moved away from the eye, in their radii, so that the back of a thin sheet
/// stays behind its front.
inline constexpr float kBackTolerance = 1.0f;
/// How far the first pass of splatting pushes splats back, in their enlarged radii, so that
/// neighbours on the same surface pass the depth test of the second. FORMULAS.md, "Two-pass depth
/// tolerance".
inline constexpr float kDepthTolerance = 1.0f;
/// Gaps between surfels are at most about this many of their radii wide.
inline constexpr float kGap = 6.5f;
/// Edge of the finest squares of means, in pixels.
inline constexpr int kFinest = 4;
/// A hole that is farther from all colours than the picture's height divided by this is not filled.
inline constexpr int kFarthest = 2;

/// One in this many surfels keeps its back. `surfels`: without those of refinement.
inline std::uint32_t one_back_in(std::size_t surfels) {
  return static_cast<std::uint32_t>(std::clamp<std::size_t>(surfels / kBacks, 1, kFewest));
}

}  // namespace pointreel::hole_rules
