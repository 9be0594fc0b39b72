#pragma once

#include <cstdint>

#include "common/base/concat.h"
#include "pointreel/error.h"

namespace pointreel {

/// The memory that decoding one frame may still take (DecodeLimits::max_memory). Decoders take what
/// they are about to allocate for a frame's points, nodes and attributes, before they allocate it.
/// They do not give back what they free on the way, so this is an upper bound, and one on the time
/// too, which grows with the same numbers.
class MemoryBudget {
 public:
  explicit MemoryBudget(std::uint64_t bytes) : all_(bytes), left_(bytes) {}

  /// Takes `bytes_each` for each of `count` things. Fails with `limit` if there is not enough left.
  Result<void> take(std::uint64_t count, std::uint64_t bytes_each) {
    if (bytes_each > 0 && count > left_ / bytes_each) {
      return fail(ErrorCode::limit, concat("takes more than the ", all_ >> 20,
                                           " MiB of memory that decoding a frame may take: raise "
                                           "--frame-memory, in programs max_memory, if you trust "
                                           "where it comes from"));
    }
    left_ -= count * bytes_each;
    return {};
  }

 private:
  std::uint64_t all_, left_;
};

}  // namespace pointreel
