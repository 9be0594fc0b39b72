#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "pointreel/error.h"

namespace pointreel {

/// The conditions of a link, for all bytes that have not left yet.
struct LinkConditions {
  std::uint64_t bits_per_second = 0;   ///< in each direction; 0: no limit
  bool rate_each = false;              ///< each connection has this rate, instead of sharing it
  std::chrono::microseconds delay{0};  ///< one way: half of the round trip
  bool cut = false;                    ///< nothing passes; open connections stay open
  std::size_t split = 0;               ///< pass on at most this many bytes at once; 0: no limit
  /// Flips one bit in about this many bytes from the target; 0: none.
  std::uint64_t corrupt_every = 0;
  /// Each connection ends after this many bytes from the target, regularly or by a reset; 0: never.
  std::uint64_t truncate_after = 0;
  std::uint64_t reset_after = 0;
};

/// A line of a script without its time: `rate 5M` (k, M, G; 0: no limit), `rate-each 5M`, `delay
/// 10` (milliseconds one way), `cut`, `restore` (ends a cut), `split 1`, `corrupt 20000`, `truncate
/// 50000`, `reset-after 50000`, `reset` (all connections), `forget` (see forget_connections),
/// `clear` (a perfect link).
struct LinkEvent {
  std::chrono::milliseconds at{0};  ///< since the start of the script
  std::string what;
};
using LinkScript = std::vector<LinkEvent>;

/// Parses lines with a time in seconds and an event, such as "5.5 rate 5M". "#" starts a comment.
Result<LinkScript> parse_link_script(std::string_view text);

/// The parsed event of a line.
struct LinkChange {
  enum class Kind {
    rate,
    rate_each,
    delay,
    split,
    corrupt,
    truncate,
    reset_after,  // the kinds up to here have a value
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
/// Changes the conditions. `reset` and `forget` act on connections and change no condition.
void apply(const LinkChange& change, LinkConditions& conditions);

}  // namespace pointreel
