#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include <ogg/ogg.h>

namespace pointreel::fuzz {

/// Ogg's pages have checksums, without which changed bytes would go no further.
inline void set_checksums(std::vector<std::uint8_t>& bytes) {
  constexpr std::size_t kHead = 27;
  const auto text = [&] {
    return std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  };
  for (std::size_t at = 0; (at = text().find("OggS", at)) != std::string_view::npos; ++at) {
    if (bytes.size() - at < kHead) return;
    const std::size_t segments = bytes[at + kHead - 1];
    const std::size_t head = kHead + segments;
    if (bytes.size() - at < head) return;
    std::size_t body = 0;
    for (std::size_t i = 0; i < segments; ++i) body += bytes[at + kHead + i];
    if (bytes.size() - at < head + body) continue;
    ogg_page page = {bytes.data() + at, static_cast<long>(head), bytes.data() + at + head,
                     static_cast<long>(body)};
    ogg_page_checksum_set(&page);
  }
}

}  // namespace pointreel::fuzz
