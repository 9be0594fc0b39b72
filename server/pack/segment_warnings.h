#pragma once

#include <string>
#include <vector>

#include "codec/sequence/encoding_options.h"
#include "server/encode/unread_properties.h"
#include "server/pack/pack_segment.h"

namespace pointreel {

/// What users are warned of while segments are packed. What holds for the whole sequence is told
/// once.
class SegmentWarnings {
 public:
  /// The lines that this segment adds.
  std::vector<std::string> fresh(const PackedSegment& segment) {
    std::vector<std::string> lines;
    if (segment.had_radii && !told_of_radii_) {
      lines.emplace_back("radii are not packed: players derive them from the voxels");
      told_of_radii_ = true;
    }
    if (segment.had_scalars && segment.summary.encode.id() == Codec::draco && !told_of_scalars_) {
      lines.emplace_back(kNoScalarsInDraco);
      told_of_scalars_ = true;
    }
    if (const std::string names = unread_.fresh(segment.unread); !names.empty())
      lines.push_back("properties of points that are not packed: " + names);
    lines.insert(lines.end(), segment.warnings.begin(), segment.warnings.end());
    return lines;
  }

 private:
  bool told_of_radii_ = false, told_of_scalars_ = false;
  UnreadProperties unread_;
};

}  // namespace pointreel
