#include "server/service/origin.h"

#include <algorithm>
#include <array>

#include <arpa/inet.h>
#include <fmt/format.h>

namespace pointreel {
namespace {

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c | 0x20) : c;
  return result;
}

/// "example.org:80" and "[::1]:80" without the port and the brackets.
std::string_view without_port(std::string_view authority) {
  if (authority.starts_with('[')) return authority.substr(1, authority.find(']') - 1);
  return authority.substr(0, authority.find(':'));
}

/// "http://example.org:80" -> "example.org:80"; empty if this is no origin of a page.
std::string_view authority_of(std::string_view origin) {
  for (const std::string_view scheme : {"http://", "https://"}) {
    if (!origin.starts_with(scheme)) continue;
    const std::string_view rest = origin.substr(scheme.size());
    return rest.find_first_of("/?#@ ,;") == std::string_view::npos ? rest : std::string_view();
  }
  return {};
}

bool is_loopback_name(const std::string& host) {
  if (host == "localhost" || host.ends_with(".localhost")) return true;
  in_addr v4{};
  if (::inet_pton(AF_INET, host.c_str(), &v4) == 1) return (ntohl(v4.s_addr) >> 24) == 127;
  in6_addr v6{};
  return ::inet_pton(AF_INET6, host.c_str(), &v6) == 1 && IN6_IS_ADDR_LOOPBACK(&v6);
}

tl::unexpected<Error> no_origin(std::string_view option, std::string_view given) {
  return fail(ErrorCode::argument,
              fmt::format("{} {}: is not an origin such as https://example.org or "
                          "http://example.org:8080, nor *",
                          option, given));
}

}  // namespace

Result<Origins> Origins::parse(const std::vector<std::string>& allowed) {
  Origins origins;
  for (const std::string& given : allowed) {
    const std::string origin = lower(given);
    const std::string_view authority = authority_of(origin);
    if (given == "*") {
      origins.any_ = true;
    } else if (authority.empty()) {
      return no_origin("--allow-origin", given);
    } else {
      origins.hosts_.emplace_back(without_port(authority));
      origins.origins_.push_back(origin);
    }
  }
  return origins;
}

Result<std::string> parse_frame_ancestors(const std::vector<std::string>& allowed) {
  std::string ancestors = "'self'";
  for (const std::string& given : allowed) {
    const std::string origin = lower(given);
    if (given != "*" && authority_of(origin).empty()) return no_origin("--embed-in", given);
    ancestors += " " + origin;
  }
  return ancestors;
}

bool Origins::lists(std::string_view origin) const {
  return !origin.empty() && std::ranges::find(origins_, lower(origin)) != origins_.end();
}

bool Origins::answers_on_loopback_for(std::string_view host) const {
  if (any_) return true;
  const std::string name = lower(without_port(host));
  return is_loopback_name(name) || std::ranges::find(hosts_, name) != hosts_.end();
}

bool Origins::allows(std::string_view origin, std::string_view host) const {
  if (origin.empty() || any_ || lists(origin)) return true;
  const std::string page = lower(origin);
  return !host.empty() && authority_of(page) == lower(host);
}

std::string Origins::fields(std::string_view origin, bool preflight) const {
  const bool allowed = any_ || lists(origin);
  std::string fields =
      fmt::format("Cross-Origin-Resource-Policy: {}\r\n", allowed ? "cross-origin" : "same-origin");
  // A cache must not give the answer for one origin to another.
  if (!any_ && !origins_.empty()) fields += "Vary: Origin\r\n";
  if (!allowed) return fields;
  fields += fmt::format(
      "Access-Control-Allow-Origin: {}\r\n"
      "Access-Control-Expose-Headers: Accept-Ranges, Content-Length, Content-Range, ETag\r\n",
      any_ ? "*" : lower(origin));
  if (preflight) {
    fields +=
        "Access-Control-Allow-Methods: GET, HEAD, OPTIONS\r\n"
        "Access-Control-Allow-Headers: Range, If-Range, If-Match, If-None-Match, Authorization\r\n"
        "Access-Control-Max-Age: 86400\r\n";
  }
  return fields;
}

}  // namespace pointreel
