#include "server/commands/bit_rates.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace pointreel {

BitRates bit_rates(std::uint64_t frame_bytes, std::uint64_t sound_bytes,
                   std::uint64_t duration_us) {
  if (duration_us == 0) return {};
  const double per_byte = 8e6 / static_cast<double>(duration_us);
  return {per_byte * static_cast<double>(frame_bytes), per_byte * static_cast<double>(sound_bytes)};
}

std::string bit_rates_text(const BitRates& rates) {
  std::string text = fmt::format("{:.3g} Mbit/s", 1e-6 * rates.frames);
  if (rates.sound > 0.0) text += fmt::format(", and {:.3g} Mbit/s of sound", 1e-6 * rates.sound);
  return text;
}

nlohmann::ordered_json bit_rates_json(const BitRates& rates) {
  return {{"frames", rates.frames}, {"audio", rates.sound}};
}

}  // namespace pointreel
