#include "common/process/print.h"

#include <cstddef>
#include <cstdint>

#include "common/base/characters.h"
#include "common/base/hide_secrets.h"

namespace pointreel {
namespace {

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
    const Character character = first_character(text);
    const std::size_t bytes = character.bytes == 0 ? 1 : character.bytes;
    if (character.bytes == 0)
      shown += fmt::format("\\x{:02x}", static_cast<unsigned char>(text[0]));
    else if (is_harmless(character.code))
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
  const std::string line = fmt::format("{}: {}\n", program, visible(hide_secrets(message)));
  std::fwrite(line.data(), 1, line.size(), stderr);
}

}  // namespace pointreel
