#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "pointreel/error.h"
#include "pointreel/octree.h"

/// The clouds that context tables are trained on: synthetic surfaces (datasets_synthetic) with
/// procedural relief, sampled in the ways of different sensors and tools. There are no real data
/// among them.
namespace pointreel::bench {

/// Calls `use` with the octree of each cloud of the training set, one after the other. The same
/// seed gives the same clouds on every machine and with any number of threads.
Result<void> for_each_training_tree(
    std::uint64_t seed, const std::function<void(const std::string& name, const Svo& svo)>& use);

}  // namespace pointreel::bench
