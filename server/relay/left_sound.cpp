#include "server/relay/left_sound.h"

#include <algorithm>
#include <cstring>

#include <ogg/ogg.h>

namespace pointreel {
namespace {

/// The longest page has less.
constexpr std::size_t kPart = 1u << 16;
/// The pages of OpusHead and OpusTags.
constexpr long kHeadPages = 2;

/// Whether the last packet of a page ends there.
bool ends_with_packet(const ogg_page& page) {
  constexpr std::uint8_t kGoesOn = 255;
  return page.header_len > 27 && page.header[page.header_len - 1] != kGoesOn;
}

}  // namespace

LeftSound find_left_sound(ByteView file) {
  LeftSound found;
  ogg_sync_state sync;
  ogg_sync_init(&sync);
  std::size_t given = 0, end = 0;
  ogg_int64_t samples = 0;
  int serial = 0;
  for (long number = 0;;) {
    ogg_page page;
    const long size = ogg_sync_pageseek(&sync, &page);
    if (size < 0) break;
    if (size == 0) {
      const std::size_t part = std::min(kPart, file.size() - given);
      char* const room = part > 0 ? ogg_sync_buffer(&sync, static_cast<long>(part)) : nullptr;
      if (room == nullptr) break;
      std::memcpy(room, file.data() + given, part);
      ogg_sync_wrote(&sync, static_cast<long>(part));
      given += part;
      continue;
    }
    if (number == 0) serial = ogg_page_serialno(&page);
    const ogg_int64_t until = ogg_page_granulepos(&page);
    if (ogg_page_pageno(&page) != number || ogg_page_serialno(&page) != serial) break;
    end += static_cast<std::size_t>(size);
    if (++number <= kHeadPages) continue;
    // No packet ends on a page without a time.
    if (until < 0) continue;
    if (until < samples) break;
    samples = until;
    if (ends_with_packet(page)) found = {end, static_cast<std::uint64_t>(samples)};
  }
  ogg_sync_clear(&sync);
  return found;
}

}  // namespace pointreel
