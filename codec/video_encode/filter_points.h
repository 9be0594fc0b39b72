#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/base/for_each.h"
#include "pointreel/executor.h"

namespace pointreel {

/// Those of the numbers of points for which `keep(number)` is true, in their order. `keep` is
/// called by several threads at once.
template <class Keep>
std::vector<std::uint32_t> filter_points(const std::vector<std::uint32_t>& of,
                                         const Executor& executor, const Keep& keep) {
  constexpr std::size_t kShare = 1u << 15;
  std::vector<std::vector<std::uint32_t>> kept((of.size() + kShare - 1) / kShare);
  for_each(executor, static_cast<int>(kept.size()), [&](int share) {
    const auto s = static_cast<std::size_t>(share);
    for (std::size_t k = s * kShare; k < std::min(of.size(), (s + 1) * kShare); ++k)
      if (keep(of[k])) kept[s].push_back(of[k]);
  });
  std::vector<std::uint32_t> all;
  for (const auto& part : kept) all.insert(all.end(), part.begin(), part.end());
  return all;
}

}  // namespace pointreel
