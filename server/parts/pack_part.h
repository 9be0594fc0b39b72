#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "codec/segments/pack_options.h"
#include "pointreel/error.h"
#include "server/pack/packer.h"
#include "server/parts/plan.h"

namespace pointreel {

/// Part `index` of `count`, counted from 1: a run of consecutive segments. The parts of a plan
/// differ by at most one segment, and some are empty if there are more parts than segments.
struct PartOf {
  std::uint32_t index = 1, count = 1;

  std::uint32_t first_segment(std::uint32_t segments) const { return bound(segments, index - 1); }
  std::uint32_t end_segment(std::uint32_t segments) const { return bound(segments, index); }

 private:
  std::uint32_t bound(std::uint32_t segments, std::uint32_t parts) const {
    return static_cast<std::uint32_t>(std::uint64_t{segments} * parts / count);
  }
};

struct PartReport {
  std::uint32_t packed = 0, already = 0;  ///< segments packed now, and by earlier runs
  std::uint32_t frames = 0;               ///< packed now
  std::vector<Error> failures;            ///< of each segment that could not be packed
};

/// Packs the segments of a part that are not there yet. Any number of processes may do so at the
/// same time, even for the same part, and may be killed at any time: a segment is in the folder of
/// the plan only when it is whole.
///
/// A segment that fails (its files cannot be read, or have changed since the plan was made) is
/// reported and does not keep the others from being packed, unless `fail_fast` is set. `options`
/// are those that PackPlan::arguments stand for.
Result<PartReport> pack_part(const PackPlan& plan, PackOptions options, PartOf part, bool fail_fast,
                             const PackListener& listener = {});

}  // namespace pointreel
