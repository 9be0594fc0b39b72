#pragma once

#include <cstdint>
#include <string>

namespace pointreel {

/// "00:01.234"; with hours where there are any.
std::string format_time(std::uint64_t us);

}  // namespace pointreel
