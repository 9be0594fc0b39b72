#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/http/http_options.h"
#include "pointreel/error.h"

namespace pointreel {

/// Why an attempt of a request failed, and whether another one is worthwhile.
struct HttpFailure {
  enum class Kind {
    final,     ///< the server would answer the same again
    doubtful,  ///< an answer that makes no sense: damaged on its way, or the server's fault
    passing,   ///< no connection, a broken one, no answer in time, 5xx
  };
  Kind kind;
  Error error;              ///< code_of_status(), unsupported where ranges are, else io
  std::string advice = {};  ///< what to do about it, if there is anything
};

HttpFailure http_failure(HttpFailure::Kind kind, std::string what, std::string advice = {});

/// The failure of an answer with this status, which is at least 300. `answer`: the beginning of its
/// body, in which an object store says what is wrong.
HttpFailure failure_of_status(long status, std::string_view answer);

/// The failure of a signed request that is to be made elsewhere: a signature is for one address.
HttpFailure failure_of_store_redirect(long status, std::string_view answer);

/// The failure of a request for `url` that a CURLcode stands for. `came`: bytes of the body that
/// came before. `said`: libcurl's own words, or nothing.
HttpFailure failure_of_transfer(int code, std::string_view url, const HttpOptions& options,
                                std::uint64_t came, std::string_view said);

/// What is wrong, and what to do.
std::string with_advice(const HttpFailure& failure);

/// The one line in which a failure is reported: the address, and that. `attempts`: how many were
/// made.
Error failure_line(const std::string& url, const HttpFailure& failure, int attempts);

}  // namespace pointreel
