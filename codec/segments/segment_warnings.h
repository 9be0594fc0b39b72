#pragma once

#include <algorithm>
#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "codec/files/unread_properties.h"
#include "codec/package/encoding_options.h"
#include "codec/segments/pack_segment.h"

namespace pointreel {

/// What users are warned of while segments are packed. What holds for the whole sequence is told
/// once, and of what holds for many frames only the first are named.
class SegmentWarnings {
 public:
  /// The lines that this segment adds.
  std::vector<std::string> fresh(const PackedSegment& segment) {
    std::vector<std::string> lines;
    if (segment.had_radii && !told_of_radii_) {
      lines.emplace_back("radii are not packed: players derive them from the voxels");
      told_of_radii_ = true;
    }
    const bool draco = segment.summary.encode.id() == Codec::draco;
    if (segment.had_scalars && (draco || segment.video) && !told_of_scalars_) {
      lines.emplace_back(draco ? kNoScalarsInDraco : kNoScalarsInVideo);
      told_of_scalars_ = true;
    }
    if (const std::string names = unread_.fresh(segment.unread); !names.empty())
      lines.push_back("properties not packed: " + names);
    for (const std::string& line : segment.warnings) {
      if (++told_[kind_of(line)] <= kMostOfAKind) lines.push_back(line);
    }
    return lines;
  }

  /// How many were left out because there were so many of their kind.
  std::vector<std::string> rest() const {
    std::vector<std::string> lines;
    for (const auto& [kind, count] : told_) {
      if (count > kMostOfAKind)
        lines.push_back(fmt::format("{} more like this: {}", count - kMostOfAKind, kind));
    }
    return lines;
  }

 private:
  static constexpr std::size_t kMostOfAKind = 8;

  /// Frames and counts are numbers, which become N.
  static std::string kind_of(const std::string& line) {
    std::string kind;
    for (const char c : line) {
      if (c < '0' || c > '9') {
        kind += c;
      } else if (kind.empty() || kind.back() != 'N') {
        kind += 'N';
      }
    }
    return kind;
  }

  std::map<std::string, std::size_t> told_;
  bool told_of_radii_ = false, told_of_scalars_ = false;
  UnreadProperties unread_;
};

/// Warnings of steps for scalar fields that no frame has. `fields`: those of the whole package.
inline std::vector<std::string> unused_steps(const PackOptions& options,
                                             const std::vector<ScalarRange>& fields) {
  std::vector<std::string> names, lines;
  const auto* octree = std::get_if<OctreeOptions>(&options.encode.codec);
  if (octree == nullptr || !octree->scalars) return lines;
  for (const ScalarRange& field : fields) names.push_back(field.name);
  for (const ScalarStep& step : octree->scalar_steps) {
    if (std::ranges::find(names, step.name) != names.end()) continue;
    lines.push_back(fmt::format(
        "--scalar-step {}: no frame has {}", step.name,
        names.empty() ? "scalar fields"
                      : fmt::format("such a scalar field; there are {}", fmt::join(names, ", "))));
  }
  return lines;
}

}  // namespace pointreel
