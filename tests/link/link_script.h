#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "pointreel/error.h"

namespace pointreel {

/// How the link is, from now on, for what has not left yet.
struct LinkConditions {
  std::uint64_t bits_per_second = 0;   ///< in each direction; 0: as fast as it goes
  bool rate_each = false;              ///< every connection has that rate, instead of sharing it
  std::chrono::microseconds delay{0};  ///< one way: half the round trip
  bool cut = false;                    ///< nothing passes; what is open stays so, unless reset
  std::size_t split = 0;               ///< at most so many bytes are handed on at once; 0: any
  /// Of what comes from the target, about one bit of so many bytes is flipped; 0: none.
  std::uint64_t corrupt_every = 0;
  /// Of what comes from the target, connections end after so many bytes: properly, or by a reset.
  /// Counted from each connection's begin; 0: they do not.
  std::uint64_t truncate_after = 0;
  std::uint64_t reset_after = 0;
};

/// A line of a script, without its time: `rate 5M` (k, M, G; 0: no limit), `rate-each 5M`, `delay
/// 10` (milliseconds one way), `cut`, `restore` (ends a cut), `split 1`, `corrupt 20000`, `truncate
/// 50000`, `reset-after 50000`, `reset` (all connections), `forget` (as forget_connections),
/// `clear` (a perfect link).
struct LinkEvent {
  std::chrono::milliseconds at{0};  ///< since the script began
  std::string what;
};
using LinkScript = std::vector<LinkEvent>;

/// Lines of a time in seconds and what happens then: "5.5 rate 5M"; "#" begins a comment.
Result<LinkScript> parse_link_script(std::string_view text);

/// What a line of a script says.
struct LinkChange {
  enum class Kind {
    rate,
    rate_each,
    delay,
    split,
    corrupt,
    truncate,
    reset_after,  // with a value
    cut,
    restore,
    reset,
    forget,
    clear
  };
  Kind kind;
  double value;
};

Result<LinkChange> parse_link_change(std::string_view text);
/// Of resets and forgetting, which are no conditions, nothing.
void apply(const LinkChange& change, LinkConditions& conditions);

}  // namespace pointreel
