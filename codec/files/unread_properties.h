#pragma once

#include <algorithm>
#include <cstddef>
#include <set>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace pointreel {

/// The names of what files have and clouds do not (LoadedCloud::unread), each of which is told once
/// for a whole sequence.
class UnreadProperties {
 public:
  /// Those that were not told before, as words; empty if there are none.
  template <class Names>
  std::string fresh(const Names& names) {
    constexpr std::size_t kMostNames = 8, kMostKept = 1000;
    std::vector<std::string> fresh;
    for (const std::string& name : names) {
      if (told_.size() < kMostKept && told_.insert(name).second) fresh.push_back(name);
    }
    const std::size_t more = fresh.size() - std::min(fresh.size(), kMostNames);
    fresh.resize(fresh.size() - more);
    return fmt::format("{}{}", fmt::join(fresh, ", "),
                       more > 0 ? fmt::format(" and {} more", more) : "");
  }

 private:
  std::set<std::string> told_;
};

}  // namespace pointreel
