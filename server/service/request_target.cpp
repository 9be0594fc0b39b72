#include "server/service/request_target.h"

#include <algorithm>

#include <fmt/format.h>

namespace pointreel {
namespace {

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  const char lower = static_cast<char>(c | 0x20);
  return lower >= 'a' && lower <= 'f' ? lower - 'a' + 10 : -1;
}

/// The byte that the escape at text[at] stands for; -1 if it is malformed.
int escaped_byte(std::string_view text, std::size_t at) {
  if (text.size() - at < 3) return -1;
  const int high = hex_digit(text[at + 1]), low = hex_digit(text[at + 2]);
  return high < 0 || low < 0 ? -1 : high * 16 + low;
}

bool is_absolute_form(std::string_view target) {
  constexpr std::string_view kScheme = "http://";
  return target.size() >= kScheme.size() &&
         std::equal(kScheme.begin(), kScheme.end(), target.begin(),
                    [](char a, char b) { return a == (b >= 'A' && b <= 'Z' ? b | 0x20 : b); });
}

}  // namespace

Result<std::string> decode_target(std::string_view target) {
  if (is_absolute_form(target)) {
    target.remove_prefix(std::string_view("http://").size());
    const auto path = target.find_first_of("/?");
    // "http://host" and "http://host?query" mean the root.
    if (path == std::string_view::npos || target[path] == '?') return std::string("/");
    target.remove_prefix(path);
  }
  if (!target.starts_with('/')) return fail("the request target must begin with /");
  target = target.substr(0, target.find('?'));

  std::string path;
  path.reserve(target.size());
  std::size_t segment = 1;  // where the present segment begins in `path`
  const auto segment_is_dots = [&] {
    const std::string_view s = std::string_view(path).substr(segment);
    return s == "." || s == "..";
  };
  for (std::size_t i = 0; i < target.size(); ++i) {
    char c = target[i];
    if (c == '/') {
      if (i > 0 && segment_is_dots()) return fail("dot segment in the request target");
      path += c;
      segment = path.size();
      continue;
    }
    if (c == '#') return fail("fragment in the request target");
    if (c == '%') {
      const int byte = escaped_byte(target, i);
      if (byte < 0) return fail("malformed percent escape in the request target");
      c = static_cast<char>(byte);
      i += 2;
      if (c == '/') return fail("encoded slash in the request target");
    }
    if (c == '\\') return fail("backslash in the request target");
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      return fail("control character in the request target");
    }
    path += c;
  }
  if (segment_is_dots()) return fail("dot segment in the request target");
  return path;
}

Result<std::string> decode_escapes(std::string_view text) {
  std::string decoded;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      decoded += text[i];
      continue;
    }
    const int byte = escaped_byte(text, i);
    if (byte < 0) return fail("malformed percent escape");
    decoded += static_cast<char>(byte);
    i += 2;
  }
  return decoded;
}

std::string encode_segment(std::string_view segment) {
  std::string encoded;
  for (const char c : segment) {
    const char lower = static_cast<char>(c | 0x20);
    const bool unreserved = (lower >= 'a' && lower <= 'z') || (c >= '0' && c <= '9') || c == '-' ||
                            c == '.' || c == '_' || c == '~';
    if (unreserved) {
      encoded += c;
    } else {
      encoded += fmt::format("%{:02X}", static_cast<unsigned>(static_cast<unsigned char>(c)));
    }
  }
  return encoded;
}

std::string encode_path(std::string_view segments) {
  std::string url;
  while (true) {
    const auto slash = segments.find('/');
    url += '/';
    url += encode_segment(segments.substr(0, slash));
    if (slash == std::string_view::npos) return url;
    segments.remove_prefix(slash + 1);
  }
}

}  // namespace pointreel
