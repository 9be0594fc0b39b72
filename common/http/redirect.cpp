#include "common/http/redirect.h"

#include <cctype>

#include <curl/curl.h>

namespace pointreel {
namespace {

/// An address as curl sees it.
class Address {
 public:
  /// `location` is relative to `base`, unless it is an address itself.
  explicit Address(const std::string& base, const std::string& location = {}) : url_(curl_url()) {
    constexpr unsigned kAsFollowed = CURLU_URLENCODE | CURLU_ALLOW_SPACE;
    valid_ = curl_url_set(url_, CURLUPART_URL, base.c_str(), kAsFollowed) == CURLUE_OK &&
             (location.empty() ||
              curl_url_set(url_, CURLUPART_URL, location.c_str(), kAsFollowed) == CURLUE_OK);
  }
  ~Address() { curl_url_cleanup(url_); }
  Address(const Address&) = delete;
  Address& operator=(const Address&) = delete;

  std::string whole() const { return part(CURLUPART_URL); }
  std::string scheme() const { return lower(part(CURLUPART_SCHEME)); }
  std::string host() const { return lower(part(CURLUPART_HOST)); }

 private:
  /// Empty if there is none, or if the address is not valid.
  std::string part(CURLUPart of) const {
    char* text = nullptr;
    if (!valid_ || curl_url_get(url_, of, &text, 0) != CURLUE_OK) return {};
    std::string copy(text);
    curl_free(text);
    return copy;
  }
  static std::string lower(std::string text) {
    for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
  }

  CURLU* const url_;
  bool valid_ = false;
};

}  // namespace

Redirect judge_redirect(const std::string& from, const std::string& location, bool to_other_hosts) {
  using enum Redirect::Verdict;
  const Address asked(from), target(from, location);
  const std::string to = target.whole().empty() ? location : target.whole();
  if (asked.scheme() == "https" && target.scheme() != "https") return {not_secure, to};
  const std::string scheme = target.scheme();
  if ((scheme != "http" && scheme != "https") || target.host().empty()) return {not_http, to};
  if (target.host() != asked.host() && !to_other_hosts) return {another_host, to};
  return {};
}

}  // namespace pointreel
