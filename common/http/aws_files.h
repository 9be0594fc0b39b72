#pragma once

#include <string>
#include <string_view>

namespace pointreel {

/// What the files of Amazon's command line say about a profile. Members that they do not mention
/// are empty.
struct AwsProfile {
  bool found = false;
  std::string key_id, secret, session_token, region, endpoint;
};

/// The two files: ~/.aws/credentials has sections [NAME], and ~/.aws/config [profile NAME], except
/// for [default].
enum class AwsFile { credentials, config };

/// Adds to `profile` what the text of a file says about the profile `name`. Members that have a
/// value keep it. Lines that are not understood are skipped: these files are shared by many
/// programs.
///
/// Trust: the text may be anything. No member becomes longer than a line of it.
void read_aws_file(std::string_view text, AwsFile kind, std::string_view name, AwsProfile& profile);

}  // namespace pointreel
