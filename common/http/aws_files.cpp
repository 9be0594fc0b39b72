#include "common/http/aws_files.h"

#include <algorithm>

namespace pointreel {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

/// The profile that the line "[...]" begins; empty if it is a section of something else.
std::string_view profile_of(std::string_view line, AwsFile kind) {
  const std::string_view name = trimmed(line.substr(1, line.find(']') - 1));
  constexpr std::string_view kProfile = "profile";
  if (kind == AwsFile::credentials || name == "default") return name;
  if (!name.starts_with(kProfile) || name.size() == kProfile.size() ||
      !is_blank(name[kProfile.size()]))
    return {};
  return trimmed(name.substr(kProfile.size()));
}

std::string* member_of(AwsProfile& profile, std::string_view key) {
  if (key == "aws_access_key_id") return &profile.key_id;
  if (key == "aws_secret_access_key") return &profile.secret;
  if (key == "aws_session_token") return &profile.session_token;
  if (key == "region") return &profile.region;
  if (key == "endpoint_url") return &profile.endpoint;
  return nullptr;
}

}  // namespace

void read_aws_file(std::string_view text, AwsFile kind, std::string_view name,
                   AwsProfile& profile) {
  bool inside = false;
  // Keys belong together: those of one file are not completed by a token of another.
  const bool has_keys = !profile.key_id.empty() || !profile.secret.empty();
  AwsProfile read;
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    // A line that begins with a blank belongs to the value of the line above, as below "s3 =".
    if (line.empty() || is_blank(line.front()) || line.front() == '#' || line.front() == ';')
      continue;
    if (line.front() == '[') {
      inside = profile_of(line, kind) == name;
      profile.found = profile.found || inside;
      continue;
    }
    const std::size_t equals = line.find('=');
    if (!inside || equals == std::string_view::npos) continue;
    if (std::string* member = member_of(read, trimmed(line.substr(0, equals))))
      *member = trimmed(line.substr(equals + 1));
  }
  if (!has_keys) {
    profile.key_id = read.key_id;
    profile.secret = read.secret;
    profile.session_token = read.session_token;
  }
  if (profile.region.empty()) profile.region = read.region;
  if (profile.endpoint.empty()) profile.endpoint = read.endpoint;
}

}  // namespace pointreel
