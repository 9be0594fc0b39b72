#include "common/http/http_failure.h"

#include <utility>

#include <curl/curl.h>
#include <fmt/format.h>

#include "common/base/words.h"
#include "common/http/store_error.h"
#include "common/net/http_status.h"
#include "common/net/untrusted.h"
#include "common/net/url.h"

namespace pointreel {
namespace {

using Kind = HttpFailure::Kind;

Kind kind_of(CURLcode code) {
  switch (code) {
    case CURLE_COULDNT_CONNECT:
    case CURLE_COULDNT_RESOLVE_HOST:
    case CURLE_COULDNT_RESOLVE_PROXY:
    case CURLE_OPERATION_TIMEDOUT:
    case CURLE_PARTIAL_FILE:
    case CURLE_GOT_NOTHING:
    case CURLE_RECV_ERROR:
    case CURLE_SEND_ERROR:
    case CURLE_SSL_CONNECT_ERROR:
      return Kind::passing;
    case CURLE_WEIRD_SERVER_REPLY:
    case CURLE_UNSUPPORTED_PROTOCOL:  // the answer does not begin as HTTP does
    case CURLE_HTTP2:
    case CURLE_HTTP2_STREAM:
    case CURLE_TOO_MANY_REDIRECTS:
    case CURLE_BAD_CONTENT_ENCODING:
    case CURLE_WRITE_ERROR:
    case CURLE_OUT_OF_MEMORY:
      return Kind::doubtful;
    default:
      return Kind::final;
  }
}

bool status_may_pass(long status) {
  return status == 408 || status == 425 || status == 429 ||
         (status >= 500 && status != 501 && status != 505);
}

const char* explain(long status) {
  switch (status) {
    case 401:
      return " (it requires a valid token; give it with --token)";
    case 403:
      return " (forbidden)";
    case 404:
      return " (not found)";
    case 416:
      return " (the file is shorter than its manifest says)";
    default:
      return "";
  }
}

}  // namespace

HttpFailure http_failure(Kind kind, std::string what, std::string advice) {
  return {kind, {std::move(what), ErrorCode::io}, std::move(advice)};
}

HttpFailure failure_of_status(long status, std::string_view answer) {
  const std::string code = store_error_code(answer);
  // Stores say by a code that the time is wrong, or that they are busy, and not by the status
  // alone.
  const bool busy = code == "SlowDown" || code == "RequestTimeout";
  HttpFailure failed =
      http_failure(busy || status_may_pass(status) ? Kind::passing : Kind::final,
                   code.empty() ? fmt::format("the server answers {}{}", status, explain(status))
                                : fmt::format("the store answers {} ({})", status, code),
                   advice_for(code));
  failed.error.code = code_of_status(status);
  return failed;
}

HttpFailure failure_of_store_redirect(long status, std::string_view answer) {
  HttpFailure failed = failure_of_status(status, answer);
  failed.error.message += ": the bucket is at another address";
  if (failed.advice.empty()) failed.advice = advice_for("PermanentRedirect");
  return failed;
}

HttpFailure failure_of_transfer(int code, std::string_view url, const HttpOptions& options,
                                std::uint64_t came, std::string_view said) {
  const auto because = [kind = kind_of(static_cast<CURLcode>(code))](std::string what,
                                                                     std::string advice = {}) {
    return http_failure(kind, std::move(what), std::move(advice));
  };
  const char* const if_it_uses_tls = url.starts_with("http:") ? "if it uses TLS, use https://" : "";
  switch (static_cast<CURLcode>(code)) {
    case CURLE_URL_MALFORMAT:
      return because("is not a valid address");
    case CURLE_COULDNT_RESOLVE_HOST:
      return because("the host's name is not known", "check the address and the network");
    case CURLE_COULDNT_CONNECT:
      return because("nothing answers there", "check host and port, and that the server runs");
    case CURLE_OPERATION_TIMEDOUT:
      return because(fmt::format("no connection within {:g} s",
                                 static_cast<double>(options.connect_timeout.count()) / 1000),
                     "check host and port");
    case CURLE_GOT_NOTHING:
      return because("the server closed the connection without an answer", if_it_uses_tls);
    case CURLE_PARTIAL_FILE:
    case CURLE_RECV_ERROR:
    case CURLE_SEND_ERROR:
      return because(fmt::format("the connection broke after {}", counted(came, "byte")),
                     came == 0 ? if_it_uses_tls : "");
    case CURLE_PEER_FAILED_VERIFICATION: {
      auto [what, advice] = untrusted(said);
      return because(std::move(what), std::move(advice));
    }
    case CURLE_SSL_CACERT_BADFILE:
      return because(fault_of_certificates(options.ca_file));
    case CURLE_SSL_CONNECT_ERROR:
      return because("the TLS handshake failed", "if the server does not use TLS, use http://");
    case CURLE_UNSUPPORTED_PROTOCOL:
    case CURLE_WEIRD_SERVER_REPLY:
      return because("the answer is not HTTP", if_it_uses_tls);
    case CURLE_TOO_MANY_REDIRECTS:
      return because("the server redirects again and again", "check the address");
    case CURLE_OUT_OF_MEMORY:
      // What libcurl says of headers beyond its limits as well.
      return because("the headers of the answer are too large, or there is not enough memory");
    default:
      return because(curl_easy_strerror(static_cast<CURLcode>(code)));
  }
}

std::string with_advice(const HttpFailure& failure) {
  const std::string& what = failure.error.message;
  return failure.advice.empty() ? what : what + "; " + failure.advice;
}

Error failure_line(const std::string& url, const HttpFailure& failure, int attempts) {
  return {fmt::format("{}: {}{}", without_secrets(url), with_advice(failure),
                      attempts > 1 ? fmt::format(" ({} attempts)", attempts) : ""),
          failure.error.code};
}

}  // namespace pointreel
