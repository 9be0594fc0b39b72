#pragma once

#include <span>

#include <nlohmann/json.hpp>

#include "tests/bench/render/draw_times.h"
#include "tests/bench/render/quality.h"

namespace pointreel::bench {

/// A row of Tables II and IV of Slomp et al., Geometry Instancing, for a scanned scene: the times
/// of all methods of instancing, the errors of the pictures that were timed, and by how much these
/// differ from each other. Measured over the first and the last view, the farthest and the nearest.
///   surfels: with the paper's Splatting::enlarged_shading, and with the default
///   voxels: of the octree for delta = 5 %, as whole cubes, and with the default
///   traverse_ms: time_traversal at depth 10
Result<nlohmann::json> measure_tables(Renderer& renderer, const RenderScene& scene,
                                      std::span<const ViewTruth> views, int runs,
                                      Stopwatch stopwatch);

}  // namespace pointreel::bench
