#include "codec/rate/bitrate.h"

#include <charconv>

namespace pointreel {

Result<double> parse_bitrate(const std::string& text) {
  double rate = 0.0;
  const char* end = text.data() + text.size();
  const auto parsed = std::from_chars(text.data(), end, rate);
  double unit = 1.0;
  if (parsed.ec == std::errc() && end - parsed.ptr == 1) {
    unit = *parsed.ptr == 'k' ? 1e3 : *parsed.ptr == 'M' ? 1e6 : *parsed.ptr == 'G' ? 1e9 : 0.0;
  } else if (parsed.ec != std::errc() || parsed.ptr != end) {
    unit = 0.0;
  }
  rate *= unit;
  if (!(rate >= 1.0 && rate <= 1e15)) {
    return fail(ErrorCode::argument,
                text + " is not a number of bits per second such as 20M, 800k or 1500000");
  }
  return rate;
}

}  // namespace pointreel
