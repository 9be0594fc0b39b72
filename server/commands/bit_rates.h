#pragma once

#include <cstdint>
#include <string>

#include <nlohmann/json_fwd.hpp>

namespace pointreel {

/// What a reel takes while it plays, in bits per second. Tables, which are fetched once, do not
/// count.
struct BitRates {
  double frames = 0.0;
  double sound = 0.0;  ///< 0 if there is none
};

/// All are 0 for a reel without a duration.
BitRates bit_rates(std::uint64_t frame_bytes, std::uint64_t sound_bytes, std::uint64_t duration_us);

/// "2.31 Mbit/s", or "2.31 Mbit/s, and 0.128 Mbit/s of sound".
std::string bit_rates_text(const BitRates& rates);

/// {"frames": 2310000.0, "audio": 128000.0}
nlohmann::ordered_json bit_rates_json(const BitRates& rates);

}  // namespace pointreel
