#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "pointreel/error.h"
#include "pointreel/octree.h"

/// What context tables are trained on: synthetic surfaces (datasets_synthetic) with procedural
/// relief, sampled as different sensors and tools do. No real data.
namespace pointreel::bench {

/// Calls `use` with the octree of each cloud of the training set, one after the other. The same
/// clouds for the same seed, on every machine and with any number of threads.
Result<void> for_each_training_tree(
    std::uint64_t seed, const std::function<void(const std::string& name, const Svo& svo)>& use);

}  // namespace pointreel::bench
