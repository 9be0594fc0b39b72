#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "common/http/aws_files.h"
#include "common/http/store_error.h"
#include "tests/fuzz/target.h"

/// Files with keys, and answers of object stores, may be anything. What is read of them stands in
/// them, on one line, and a code has nothing but letters and digits.
FUZZ_TARGET(aws_files) {
  const std::string_view text = as_text(input);
  for (const AwsFile kind : {AwsFile::credentials, AwsFile::config}) {
    for (const char* name : {"default", "work"}) {
      AwsProfile profile;
      read_aws_file(text, kind, name, profile);
      for (const std::string* member : {&profile.key_id, &profile.secret, &profile.session_token,
                                        &profile.region, &profile.endpoint}) {
        if (member->find('\n') != std::string::npos) std::abort();
        if (text.find(*member) == std::string_view::npos) std::abort();
        if (!member->empty() && !profile.found) std::abort();
      }
      // What is known already stays.
      const AwsProfile before = profile;
      read_aws_file(text, kind, name, profile);
      if (!before.secret.empty() && profile.secret != before.secret) std::abort();
    }
  }
  const std::string code = store_error_code(text);
  if (code.size() > 64 || text.find(code) == std::string_view::npos) std::abort();
  const bool plain = std::all_of(code.begin(), code.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
  });
  if (!plain) std::abort();
}
