#include "common/base/print.h"

#include <cstddef>
#include <cstdint>

namespace pointreel {
namespace {

/// A character, and how many bytes it takes; 0 bytes if there is no valid one.
struct Character {
  std::uint32_t code = 0;
  std::size_t bytes = 0;
};

/// The first character of a text that is not empty, by table 3-7 of the Unicode Standard.
Character first_of(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned lead = byte(0);
  if (lead < 0x80) return {lead, 1};
  const std::size_t bytes = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
  if (lead < 0xc2 || lead > 0xf4 || text.size() < bytes) return {};
  std::uint32_t code = lead & (0x7fu >> bytes);
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return {};
    code = code << 6 | (byte(i) & 0x3f);
  }
  const bool too_long = (bytes == 3 && code < 0x800) || (bytes == 4 && code < 0x10000);
  const bool surrogate = code >= 0xd800 && code <= 0xdfff;
  if (too_long || surrogate || code > 0x10ffff) return {};
  return {code, bytes};
}

bool may_be_printed(std::uint32_t code) {
  const auto within = [code](std::uint32_t first, std::uint32_t last) {
    return code >= first && code <= last;
  };
  return !(code < 0x20 || within(0x7f, 0x9f) ||  // C0, DEL and C1
           code == 0x61c || within(0x200e, 0x200f) || within(0x202a, 0x202e) ||
           within(0x2066, 0x2069) ||  // directions of writing
           within(0x2028, 0x2029) ||  // breaks of lines and paragraphs
           code == 0xfeff || within(0xfff9, 0xfffb) || within(0xe0000, 0xe007f));  // invisible
}

std::string escape(std::uint32_t code) {
  if (code == '\n') return "\\n";
  if (code == '\r') return "\\r";
  if (code == '\t') return "\\t";
  if (code < 0x80) return fmt::format("\\x{:02x}", code);
  return code < 0x10000 ? fmt::format("\\u{:04x}", code) : fmt::format("\\U{:08x}", code);
}

}  // namespace

std::string visible(std::string_view text) {
  std::string shown;
  shown.reserve(text.size());
  while (!text.empty()) {
    const Character character = first_of(text);
    const std::size_t bytes = character.bytes == 0 ? 1 : character.bytes;
    if (character.bytes == 0)
      shown += fmt::format("\\x{:02x}", static_cast<unsigned char>(text[0]));
    else if (may_be_printed(character.code))
      shown += text.substr(0, bytes);
    else
      shown += escape(character.code);
    text.remove_prefix(bytes);
  }
  return shown;
}

bool print_lines(std::string_view text) {
  std::string shown;
  for (std::size_t end; (end = text.find('\n')) != std::string_view::npos;
       text.remove_prefix(end + 1))
    shown += visible(text.substr(0, end)) + "\n";
  shown += visible(text);
  return std::fwrite(shown.data(), 1, shown.size(), stdout) == shown.size() &&
         std::fflush(stdout) == 0;
}

void print_error(std::string_view program, std::string_view message) {
  const std::string line = fmt::format("{}: {}\n", program, visible(message));
  std::fwrite(line.data(), 1, line.size(), stderr);
}

}  // namespace pointreel
