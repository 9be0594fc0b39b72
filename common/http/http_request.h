#pragma once

#include <string>

#include "common/http/http_options.h"

// As in curl/curl.h, which few sources include.
typedef void CURL;

namespace pointreel {

/// Prepares libcurl, once for the process.
void start_http();

/// Resets a handle and prepares it for a request, as all requests of Pointreel are made: over http
/// and https only, past the proxy if it goes to this machine, and without signals. `url` and
/// `options` outlive the request.
void prepare_request(CURL* handle, const std::string& url, const HttpOptions& options);

/// The status of the handle's newest answer; 0 if there is none.
long status_of(CURL* handle);

}  // namespace pointreel
