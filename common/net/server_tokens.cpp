#include "common/net/server_tokens.h"

#include <algorithm>
#include <fstream>
#include <utility>

#include <fmt/format.h>

#include "common/base/characters.h"
#include "common/base/try.h"
#include "common/net/url.h"

namespace pointreel {
namespace {

std::string server_of(const Url& url) {
  std::string host = url.host;
  std::transform(host.begin(), host.end(), host.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
  return fmt::format("{}{}:{}", url.tls() ? "tls://" : "", host, url.port);
}

bool is_server(const Url& url) { return url.is_http() || url.is_websocket(); }

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

}  // namespace

Result<ServerTokens> ServerTokens::parse(std::string_view text) {
  ServerTokens tokens;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = trimmed(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.empty() || line.front() == '#') continue;
    const auto wrong = [number](const char* what) {
      return fail(ErrorCode::argument, fmt::format("line {}: {}", number, what));
    };
    const auto blank = std::find_if(line.begin(), line.end(), is_blank);
    const std::string address(line.begin(), blank);
    const std::string_view token = trimmed({blank, line.end()});
    // What does not look as it should may be a token: it is not repeated.
    const auto url = parse_url(address);
    if (!url || !is_server(*url) || url->target != "/" || !url->user.empty())
      return wrong("does not begin with the address of a server, such as wss://HOST:PORT");
    if (token.empty()) return wrong("has no token behind the address");
    if (has_blank(token))
      return wrong("has a token with a blank or a control character, which no token may have");
    if (!tokens.tokens_.emplace(server_of(*url), token).second)
      return wrong("is the second for this server");
  }
  return tokens;
}

Result<ServerTokens> ServerTokens::read(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string text(kMostBytes + 1, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (in.bad() || !in.eof()) {
    const bool too_long = in.good();
    return fail(ErrorCode::argument,
                fmt::format("{}: {}", file.string(),
                            too_long ? fmt::format("has more than {} bytes", kMostBytes)
                                     : "cannot be read"));
  }
  text.resize(static_cast<std::size_t>(in.gcount()));
  return at_place(file.string(), parse(text));
}

const std::string* ServerTokens::of(const std::string& url) const {
  const auto parsed = parse_url(url);
  if (!parsed || !is_server(*parsed)) return nullptr;
  const auto found = tokens_.find(server_of(*parsed));
  return found == tokens_.end() ? nullptr : &found->second;
}

}  // namespace pointreel
