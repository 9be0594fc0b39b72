#pragma once

#include "common/http/aws_access.h"

// As in curl/curl.h, which few sources include.
typedef void CURL;
struct curl_slist;

namespace pointreel {

/// Lets curl sign the handle's next request for an object store (AWS Signature Version 4), and
/// appends the headers that this needs. The caller sets CURLOPT_HTTPHEADER to the result. `access`
/// outlives the request.
///
/// The body is not signed (UNSIGNED-PAYLOAD): curl 7.88 would sign an empty one in its place. It
/// signs the path as it stands in the address, which must therefore be percent-encoded already, and
/// all headers of the list: none may be empty, and no name may begin with another one.
curl_slist* sign(CURL* handle, curl_slist* headers, const AwsAccess& access);

}  // namespace pointreel
