#pragma once

#include <functional>
#include <optional>
#include <string>

#include "pointreel/error.h"

namespace pointreel {

/// What requests to an object store are signed with. It is never printed: not in errors, not in
/// logs.
struct AwsAccess {
  std::string key_id, secret;
  std::string session_token;  ///< empty if the keys are not temporary
  std::string region;
};

/// An object store that speaks S3, and the right to use it.
struct Store {
  std::string endpoint;  ///< such as https://s3.eu-central-1.amazonaws.com, no slash at the end
  AwsAccess access;
};

/// The value of an environment variable; none if it is not set, or set to nothing.
using Environment = std::function<std::optional<std::string>(const char* variable)>;
std::optional<std::string> process_environment(const char* variable);

/// The store that s3:// means here, found as Amazon's own programs find it.
///
/// Keys: AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY and AWS_SESSION_TOKEN, or else those of the
/// profile AWS_PROFILE ("default") in AWS_SHARED_CREDENTIALS_FILE (~/.aws/credentials), or else in
/// AWS_CONFIG_FILE (~/.aws/config).
/// Region: AWS_REGION, AWS_DEFAULT_REGION, the profile's, or us-east-1.
/// Endpoint: `endpoint` if it is not empty, AWS_ENDPOINT_URL_S3, AWS_ENDPOINT_URL, the profile's,
/// or Amazon's in that region.
///
/// Errors: `argument` where something is missing or has characters that it cannot have. They name
/// the variable or the file, and never a value that is secret.
Result<Store> resolve_store(const std::string& endpoint,
                            const Environment& environment = process_environment);

}  // namespace pointreel
