#pragma once

#include <string>

#include "pointreel/error.h"

namespace pointreel {

/// Bits per second from "20M", "800k", "1.5G" or a plain number. Errors: `argument`.
Result<double> parse_bitrate(const std::string& text);

}  // namespace pointreel
