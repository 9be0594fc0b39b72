#pragma once

#include <span>

#include <nlohmann/json.hpp>

#include "tests/bench/render/draw_times.h"
#include "tests/bench/render/quality.h"

namespace pointreel::bench {

/// A row of the paper's Tables II and IV (002, section VII) for a scanned scene, with all methods
/// of instancing, and of the pictures that they time: their error, and by how much they differ from
/// each other. Over the first and the last of the views, the farthest and the nearest.
///   surfels: as the paper's Splatting::enlarged_shading, and the default
///   voxels: of the octree that delta = 5 % gives, whole cubes, and the default
///   traverse_ms: time_traversal at depth 10
Result<nlohmann::json> measure_tables(Renderer& renderer, const RenderScene& scene,
                                      std::span<const ViewTruth> views, int runs,
                                      Stopwatch stopwatch);

}  // namespace pointreel::bench
