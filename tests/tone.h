#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>

namespace pointreel {

/// Writes a WAV file whose sample number n is `wave(n)` in both of its channels, 16 bits each.
template <class Wave>
void write_wav(const std::filesystem::path& path, std::uint32_t rate, std::uint32_t samples,
               const Wave& wave) {
  std::ofstream out(path, std::ios::binary);
  const auto put = [&out](std::uint32_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) out.put(static_cast<char>(value >> (8 * i) & 0xff));
  };
  out << "RIFF";
  put(36 + 4 * samples, 4);
  out << "WAVEfmt ";
  put(16, 4);
  put(1, 2);
  put(2, 2);
  put(rate, 4);
  put(4 * rate, 4);
  put(4, 2);
  put(16, 2);
  out << "data";
  put(4 * samples, 4);
  for (std::uint32_t n = 0; n < samples; ++n) {
    const auto value = static_cast<std::uint32_t>(static_cast<std::int32_t>(32767.0 * wave(n)));
    put(value, 2);
    put(value, 2);
  }
}

}  // namespace pointreel
