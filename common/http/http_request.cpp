#include "common/http/http_request.h"

#include <curl/curl.h>

#include "common/net/url.h"

namespace pointreel {
namespace {

bool is_loopback(const std::string& text) {
  const auto url = parse_url(text);
  return url && (url->host.starts_with("127.") || url->host == "localhost" || url->host == "::1");
}

}  // namespace

void start_http() {
  [[maybe_unused]] static const CURLcode global = curl_global_init(CURL_GLOBAL_DEFAULT);
}

void prepare_request(CURL* handle, const std::string& url, const HttpOptions& options) {
  curl_easy_reset(handle);
  const auto set = [handle](CURLoption option, auto value) {
    curl_easy_setopt(handle, option, value);
  };
  set(CURLOPT_URL, url.c_str());
  set(CURLOPT_NOSIGNAL, 1L);
  set(CURLOPT_QUICK_EXIT, 1L);  // does not wait until the lookup of a host's name ends
  set(CURLOPT_PROTOCOLS_STR, "http,https");
  set(CURLOPT_REDIR_PROTOCOLS_STR, "http,https");
  set(CURLOPT_USERAGENT, "pointreel");
  set(CURLOPT_CONNECTTIMEOUT_MS, static_cast<long>(options.connect_timeout.count()));
  // A proxy that the environment names is meant for other machines.
  if (is_loopback(url)) set(CURLOPT_PROXY, "");
  if (!options.ca_file.empty()) set(CURLOPT_CAINFO, options.ca_file.c_str());
}

long status_of(CURL* handle) {
  long status = 0;
  curl_easy_getinfo(handle, CURLINFO_RESPONSE_CODE, &status);
  return status;
}

}  // namespace pointreel
