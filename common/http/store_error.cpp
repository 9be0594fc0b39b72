#include "common/http/store_error.h"

#include <algorithm>

namespace pointreel {

std::string store_error_code(std::string_view answer) {
  constexpr std::string_view kError = "<Error>", kBegin = "<Code>", kEnd = "</Code>";
  constexpr std::size_t kLongest = 64;
  const std::size_t error = answer.find(kError);
  if (error == std::string_view::npos) return {};
  const std::size_t begin = answer.find(kBegin, error);
  if (begin == std::string_view::npos) return {};
  answer.remove_prefix(begin + kBegin.size());
  const std::string_view code = answer.substr(0, answer.substr(0, kLongest + 1).find('<'));
  if (code.empty() || code.size() > kLongest || !answer.substr(code.size()).starts_with(kEnd))
    return {};
  const bool plain = std::all_of(code.begin(), code.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
  });
  return plain ? std::string(code) : std::string();
}

const char* advice_for(std::string_view code) {
  if (code == "NoSuchBucket") return "create the bucket, or check its name";
  if (code == "AccessDenied" || code == "AllAccessDisabled")
    return "these keys have no right to it; check the keys, their rights and the address";
  if (code == "InvalidAccessKeyId" || code == "InvalidClientTokenId")
    return "the store does not know this key; check AWS_ACCESS_KEY_ID or the profile, and "
           "--endpoint";
  if (code == "SignatureDoesNotMatch")
    return "check AWS_SECRET_ACCESS_KEY or the profile, and --endpoint";
  if (code == "ExpiredToken" || code == "InvalidToken" || code == "TokenRefreshRequired")
    return "the keys are temporary and no longer valid; get new ones";
  if (code == "RequestTimeTooSkewed") return "set the clock of this machine";
  if (code == "PermanentRedirect" || code == "TemporaryRedirect" ||
      code == "AuthorizationHeaderMalformed" || code == "IllegalLocationConstraintException")
    return "set AWS_REGION to the region of the bucket, and --endpoint if it is not Amazon's";
  if (code == "SlowDown" || code == "ServiceUnavailable")
    return "the store is busy; try again later";
  if (code == "EntityTooLarge") return "the store takes no file as large as this";
  return "";
}

}  // namespace pointreel
