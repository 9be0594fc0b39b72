#include "common/http/aws_access.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <system_error>

#include <fmt/format.h>

#include "common/base/try.h"
#include "common/http/aws_files.h"
#include "common/net/url.h"

namespace pointreel {
namespace {

/// Real files have a few kilobytes.
constexpr std::size_t kMaxFile = 1u << 20;

auto wrong(std::string message) { return fail(ErrorCode::argument, std::move(message)); }

/// A file's text. Empty if it is not there and was not named by the user.
Result<std::string> read_text(const std::string& path, bool named) {
  std::error_code error;
  if (path.empty() || (!named && !std::filesystem::exists(path, error))) return std::string();
  if (!std::filesystem::is_regular_file(path, error))
    return wrong(path + ": is not a file; it should hold the keys of a store");
  std::ifstream in(path, std::ios::binary);
  std::string text(kMaxFile + 1, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(in.gcount()));
  if (in.bad() || !in.eof() || text.size() > kMaxFile)
    return wrong(fmt::format("{}: cannot be read, or has more than {} bytes", path, kMaxFile));
  return text;
}

bool is_visible(const std::string& text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return c > ' ' && c < 127; });
}

bool is_region(const std::string& text) {
  return !text.empty() && text.size() <= 64 && std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-';
  });
}

Result<AwsProfile> read_profile(const Environment& environment) {
  const std::string home = environment("HOME").value_or("");
  const auto path_of = [&](const char* variable, const char* usual) -> std::string {
    if (const auto named = environment(variable)) return *named;
    return home.empty() ? std::string() : home + usual;
  };
  const auto named = environment("AWS_PROFILE");
  const std::string name = named.value_or("default");
  const std::string credentials = path_of("AWS_SHARED_CREDENTIALS_FILE", "/.aws/credentials");
  const std::string config = path_of("AWS_CONFIG_FILE", "/.aws/config");
  AwsProfile profile;
  read_aws_file(TRY(read_text(credentials, environment("AWS_SHARED_CREDENTIALS_FILE").has_value())),
                AwsFile::credentials, name, profile);
  read_aws_file(TRY(read_text(config, environment("AWS_CONFIG_FILE").has_value())), AwsFile::config,
                name, profile);
  if (named && !profile.found)
    return wrong(fmt::format("AWS_PROFILE: neither {} nor {} has a profile \"{}\"", credentials,
                             config, name));
  return profile;
}

Result<AwsAccess> find_keys(const Environment& environment, const AwsProfile& profile) {
  const auto key_id = environment("AWS_ACCESS_KEY_ID");
  const auto secret = environment("AWS_SECRET_ACCESS_KEY");
  AwsAccess access;
  std::string place = "the environment";
  if (key_id.has_value() != secret.has_value())
    return wrong(fmt::format("AWS_{} is set, but AWS_{} is not; set both",
                             key_id ? "ACCESS_KEY_ID" : "SECRET_ACCESS_KEY",
                             key_id ? "SECRET_ACCESS_KEY" : "ACCESS_KEY_ID"));
  if (key_id) {
    access = {*key_id, *secret, environment("AWS_SESSION_TOKEN").value_or(""), {}};
  } else if (!profile.key_id.empty() && !profile.secret.empty()) {
    access = {profile.key_id, profile.secret, profile.session_token, {}};
    place = "the profile";
  } else {
    return wrong(
        "there are no keys for the store; set AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY, or "
        "write them into ~/.aws/credentials");
  }
  // They become parts of a request.
  for (const std::string* text : {&access.key_id, &access.secret, &access.session_token})
    if (!is_visible(*text))
      return wrong("a key for the store, in " + place +
                   ", has a blank or a character that no key has; copy it again");
  return access;
}

}  // namespace

std::optional<std::string> process_environment(const char* variable) {
  const char* value = std::getenv(variable);
  if (value == nullptr || *value == '\0') return std::nullopt;
  return value;
}

Result<Store> resolve_store(const std::string& endpoint, const Environment& environment) {
  const AwsProfile profile = TRY(read_profile(environment));
  Store store;
  store.access = TRY(find_keys(environment, profile));
  const auto first_of = [&](const char* first, const char* second, const std::string& last) {
    if (const auto value = environment(first)) return *value;
    if (const auto value = environment(second)) return *value;
    return last;
  };
  std::string& region = store.access.region;
  region = first_of("AWS_REGION", "AWS_DEFAULT_REGION", profile.region);
  if (region.empty()) region = "us-east-1";
  if (!is_region(region))
    return wrong(fmt::format("\"{}\" is not the name of a region, such as eu-central-1", region));
  store.endpoint = endpoint;
  if (endpoint.empty())
    store.endpoint = first_of("AWS_ENDPOINT_URL_S3", "AWS_ENDPOINT_URL", profile.endpoint);
  if (store.endpoint.empty()) store.endpoint = fmt::format("https://s3.{}.amazonaws.com", region);
  while (store.endpoint.ends_with('/')) store.endpoint.pop_back();
  const Url url = TRY(parse_url(store.endpoint));
  if (!url.is_http() || !url.user.empty() ||
      store.endpoint.find_first_of("?#") != std::string::npos)
    return wrong(
        "the endpoint of a store is an address such as https://s3.example.org, without a user or a "
        "query; correct --endpoint or AWS_ENDPOINT_URL");
  return store;
}

}  // namespace pointreel
