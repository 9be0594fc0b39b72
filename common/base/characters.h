#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

/// Which characters of text that others wrote may be shown to people as they are.
namespace pointreel {

/// A character, and how many bytes it takes; 0 bytes if there is no valid one.
struct Character {
  std::uint32_t code = 0;
  std::size_t bytes = 0;
};

/// The first character of a text that is not empty, by table 3-7 of the Unicode Standard.
Character first_character(std::string_view text);

/// False for control characters (C0, DEL and C1), and for characters that change the direction of
/// writing, break lines or are invisible.
bool is_harmless(std::uint32_t code);

/// True if the text is UTF-8 of harmless characters only.
///
/// Trust: the text may be hostile.
bool is_harmless(std::string_view text);

/// True if the text has a space or an ASCII control character, as addresses and tokens must not.
bool has_blank(std::string_view text);

}  // namespace pointreel
