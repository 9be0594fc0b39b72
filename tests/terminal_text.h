#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <random>
#include <string>
#include <string_view>

namespace pointreel {

/// Text as an attacker would name a file: random bytes, controls of terminals and of the direction
/// of writing, and some harmless letters. It has no NUL and no slash, so that it can name a file.
inline std::string foreign_text(std::mt19937& random, std::size_t most = 40) {
  constexpr std::array<std::string_view, 16> kPieces = {"\x1b]0;x\x07",
                                                        "\x1b[2J",
                                                        "\x9b"
                                                        "31m",
                                                        "\xc2\x9b"
                                                        "2J",
                                                        "\xc2\x90",
                                                        "\xe2\x80\xae",
                                                        "\xe2\x81\xa6",
                                                        "\xe2\x80\xa8",
                                                        "\r",
                                                        "\n",
                                                        "\b\b",
                                                        "\x7f",
                                                        "\xc3\xbc",
                                                        "\xf0\x9f\x99\x82",
                                                        "abc",
                                                        "\xed\xa0\x80"};
  std::string text;
  const std::size_t length = 1 + random() % most;
  while (text.size() < length) {
    const auto byte = static_cast<char>(1 + random() % 255);
    if (random() % 2 == 0)
      text += kPieces[random() % kPieces.size()];
    else if (byte != '/')
      text += byte;
  }
  return text;
}

/// What in a program's output could do harm in a terminal; empty if there is nothing. Lines may be
/// broken. Written apart from `visible`, which makes such output.
inline std::string harm_to_terminal(std::string_view output) {
  for (std::size_t i = 0; i < output.size();) {
    const auto lead = static_cast<unsigned char>(output[i]);
    if (lead < 0x80) {
      if ((lead < 0x20 && lead != '\n') || lead == 0x7f) return "a control character of ASCII";
      ++i;
      continue;
    }
    std::size_t more = 0;
    std::uint32_t code = 0, least = 0;
    if ((lead & 0xe0) == 0xc0) {
      more = 1, code = lead & 0x1fu, least = 0x80;
    } else if ((lead & 0xf0) == 0xe0) {
      more = 2, code = lead & 0x0fu, least = 0x800;
    } else if ((lead & 0xf8) == 0xf0) {
      more = 3, code = lead & 0x07u, least = 0x10000;
    } else {
      return "a byte that is not UTF-8";
    }
    for (std::size_t k = 1; k <= more; ++k) {
      if (i + k >= output.size() || (static_cast<unsigned char>(output[i + k]) & 0xc0) != 0x80)
        return "bytes that are not UTF-8";
      code = code << 6 | (static_cast<unsigned char>(output[i + k]) & 0x3fu);
    }
    if (code < least || code > 0x10ffff || (code >= 0xd800 && code < 0xe000))
      return "bytes that are not UTF-8";
    if (code < 0xa0) return "a control character of C1";
    if ((code >= 0x202a && code <= 0x202e) || (code >= 0x2066 && code <= 0x2069))
      return "a change of the direction of writing";
    i += 1 + more;
  }
  return {};
}

}  // namespace pointreel
