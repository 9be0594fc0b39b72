#include "common/net/url.h"

#include <algorithm>
#include <charconv>

#include "common/base/characters.h"

namespace pointreel {

std::string Url::place() const {
  const bool ipv6 = host.find(':') != std::string::npos;
  return (ipv6 ? "[" + host + "]" : host) + ":" + std::to_string(port);
}

std::string_view scheme_of(std::string_view text) {
  const std::size_t end = text.find("://");
  return end == std::string_view::npos ? std::string_view() : text.substr(0, end);
}

Result<Url> parse_url(const std::string& text) {
  const auto refused = [&](const char* why) {
    return fail(ErrorCode::argument, without_secrets(text) + ": " + why);
  };
  const std::string_view scheme = scheme_of(text);
  if (scheme.empty()) return refused("is not an address such as https://HOST/NAME");
  if (has_blank(text)) return refused("contains a blank or a control character");
  Url url;
  for (const char c : scheme)
    url.scheme += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;

  const std::string_view rest = std::string_view(text).substr(scheme.size() + 3);
  const std::size_t path = std::min(rest.find_first_of("/?#"), rest.size());
  url.target = rest.substr(path, rest.find('#') - path);
  if (!url.target.starts_with('/')) url.target.insert(url.target.begin(), '/');

  std::string_view authority = rest.substr(0, path);
  if (const std::size_t at = authority.rfind('@'); at != std::string_view::npos) {
    url.user = authority.substr(0, at);
    authority.remove_prefix(at + 1);
  }
  std::string_view port;  // from its colon on
  if (authority.starts_with('[')) {
    const std::size_t end = authority.find(']');
    if (end == std::string_view::npos) return refused("the IPv6 address lacks its closing ]");
    url.host = authority.substr(1, end - 1);
    port = authority.substr(end + 1);
  } else {
    const std::size_t colon = std::min(authority.find(':'), authority.size());
    url.host = authority.substr(0, colon);
    port = authority.substr(colon);
  }
  if (url.host.empty()) return refused("names no host");
  url.port = url.tls() ? 443 : 80;
  if (port.empty()) return url;
  const auto [end, error] = std::from_chars(port.data() + 1, port.data() + port.size(), url.port);
  if (port.front() != ':' || error != std::errc() || end != port.data() + port.size() ||
      url.port == 0)
    return refused("the port is not a number from 1 to 65535");
  return url;
}

std::string without_secrets(const std::string& url) {
  if (scheme_of(url).empty()) return url;
  std::string shown = url.substr(0, url.find_first_of("?#"));
  if (url.find('?') != std::string::npos) shown += "?...";
  const std::size_t begin = shown.find("://");
  if (begin == std::string::npos) return shown;
  const std::size_t end = std::min(shown.find('/', begin + 3), shown.size());
  const std::size_t at = shown.rfind('@', end);
  if (at != std::string::npos && at > begin) shown.erase(begin + 3, at + 1 - (begin + 3));
  return shown;
}

Result<void> check_token(std::string_view token) {
  if (!has_blank(token)) return {};
  return fail(ErrorCode::argument,
              "the token has a blank or a control character, which no token may have");
}

}  // namespace pointreel
