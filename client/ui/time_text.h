#pragma once

#include <cstdint>
#include <string>

namespace pointreel {

/// "00:01.234", or "1:00:01.234" from an hour on.
std::string format_time(std::uint64_t us);

}  // namespace pointreel
