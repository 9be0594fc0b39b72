#include "common/http/aws_signature.h"

#include <curl/curl.h>

namespace pointreel {

curl_slist* sign(CURL* handle, curl_slist* headers, const AwsAccess& access) {
  curl_easy_setopt(handle, CURLOPT_AWS_SIGV4, ("aws:amz:" + access.region + ":s3").c_str());
  curl_easy_setopt(handle, CURLOPT_USERNAME, access.key_id.c_str());
  curl_easy_setopt(handle, CURLOPT_PASSWORD, access.secret.c_str());
  headers = curl_slist_append(headers, "x-amz-content-sha256: UNSIGNED-PAYLOAD");
  if (!access.session_token.empty())
    headers = curl_slist_append(headers, ("x-amz-security-token: " + access.session_token).c_str());
  return headers;
}

}  // namespace pointreel
