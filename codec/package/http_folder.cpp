#include "codec/package/http_folder.h"

#include <algorithm>

#include <fmt/format.h>

#include "codec/package/manifest.h"
#include "common/base/try.h"
#include "common/net/url.h"

namespace pointreel {
namespace {

constexpr std::string_view kStoreScheme = "s3://";

bool is_letter_or_digit(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
}

/// What follows a slash, up to the next one.
bool is_step(std::string_view step) { return !step.empty() && step != "." && step != ".."; }

/// The manifest's name and slashes at the end say nothing about a folder.
void trim_to_folder(std::string& path) {
  if (const std::string tail = std::string("/") + kManifestName; path.ends_with(tail))
    path.resize(path.size() - tail.size());
  while (path.ends_with('/')) path.pop_back();
}

std::string percent_encoded(std::string_view key) {
  std::string encoded;
  for (const char c : key) {
    if (is_letter_or_digit(c) || std::string_view("-._~/").find(c) != std::string_view::npos)
      encoded += c;
    else
      encoded += fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return encoded;
}

}  // namespace

std::string HttpFolder::manifest() const { return file(kManifestName); }

bool is_store_address(std::string_view text) { return text.starts_with(kStoreScheme); }

bool is_folder_address(std::string_view text) {
  if (is_store_address(text)) return true;
  const auto url = parse_url(std::string(text));
  return url && url->is_http();
}

Result<HttpFolder> parse_http_folder(const std::string& url) {
  TRY(parse_url(url));
  HttpFolder folder{url.substr(0, url.find('#')), {}};
  if (const std::size_t query = folder.base.find('?'); query != std::string::npos) {
    folder.query = folder.base.substr(query);
    folder.base.resize(query);
  }
  trim_to_folder(folder.base);
  return folder;
}

Result<HttpFolder> parse_store_folder(const std::string& address, const Store& store) {
  const auto refused = [&](const char* why) {
    return fail(ErrorCode::argument, without_secrets(address) + ": " + why);
  };
  std::string key(std::string_view(address).substr(kStoreScheme.size()));
  trim_to_folder(key);
  const std::string bucket = key.substr(0, key.find('/'));
  const bool named = !bucket.empty() && bucket.size() <= 255 &&
                     std::all_of(bucket.begin(), bucket.end(), [](char c) {
                       return is_letter_or_digit(c) || c == '.' || c == '-' || c == '_';
                     });
  if (!named || !is_step(bucket)) return refused("names no bucket; give s3://BUCKET/REEL");
  if (key.size() == bucket.size())
    return refused("names a bucket, but no package in it; give s3://BUCKET/REEL");
  key.erase(0, bucket.size() + 1);
  constexpr std::size_t kLongest = 700;  // of 1024, which leaves room for the names of files
  if (key.size() > kLongest) return refused("is too long for an object store");
  for (std::string_view rest = key;;) {
    const std::string_view step = rest.substr(0, rest.find('/'));
    if (!is_step(step)) return refused("has a part that is empty, \".\" or \"..\"");
    if (step.size() == rest.size()) break;
    rest.remove_prefix(step.size() + 1);
  }
  if (std::any_of(key.begin(), key.end(),
                  [](char c) { return static_cast<unsigned char>(c) < 32 || c == 127; }))
    return refused("has a control character");
  return HttpFolder{store.endpoint + "/" + bucket + "/" + percent_encoded(key), {}, store.access};
}

Result<HttpFolder> resolve_folder(const std::string& address, const std::string& endpoint) {
  if (!is_store_address(address)) return parse_http_folder(address);
  const auto store = resolve_store(endpoint);
  if (!store) return fail_at(address, store.error());
  return parse_store_folder(address, *store);
}

}  // namespace pointreel
