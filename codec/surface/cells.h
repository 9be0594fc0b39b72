#pragma once

#include "codec/core/build.h"
#include "pointreel/cloud.h"
#include "pointreel/executor.h"

namespace pointreel {

/// Points sorted into the leaves of an octree whose cells are as large as its user wants.
struct SortedIntoCells {
  SortedPoints sorted;  ///< some levels deeper than `level`, so that duplicates can be told
  int level = 0;        ///< of the leaves
};

/// Sorts the points of a cloud into cells that hold `points_per_cell` distinct points on average. A
/// cell and its 26 neighbours then hold about twelve times as many.
SortedIntoCells sort_into_cells(const PointCloud& cloud, double points_per_cell,
                                const Executor& executor = {});

/// The finest level, at most `limit`, whose cells contain at least that many distinct points on
/// average.
int choose_level(const SortedPoints& sorted, double points_per_cell, int limit);

}  // namespace pointreel
