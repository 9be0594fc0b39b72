#pragma once

#include <span>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "pointreel/octree.h"

namespace pointreel {

/// How far the surface lies from the centres of an octree's leaves: for each leaf, a distance along
/// its normal, in the units of the cube. Putting surfels there takes most of the steps away that
/// cells leave in a surface.
///
/// Two neighbouring leaves lie on an arc whose chord is perpendicular to the mean of their normals.
/// The height of a leaf is the mean of what this tells it about each of its 26 neighbours, which
/// is exact for planes and spheres; a few rounds carry it further than to the next cell. A
/// surfel never leaves its cell by that: heights are at most half the extent of the cell along the
/// normal. Formulas: common/FORMULAS.md, "Heights of leaves".
///
/// `normals` are those of the leaves, of length 32767, or zero where unknown: such leaves stay in
/// the middle and tell others nothing. Where neighbours' normals differ much, as at the two sides
/// of a thin sheet, they do not count either. `lines`: the signs of the normals are unknown.
///
/// O(nodes). Throws nothing but std::bad_alloc.
std::vector<float> leaf_heights(const Svo& svo, std::span<const glm::i16vec3> normals, bool lines);

}  // namespace pointreel
