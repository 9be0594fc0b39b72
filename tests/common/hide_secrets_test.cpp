#include "common/base/hide_secrets.h"

#include <gtest/gtest.h>

namespace pointreel::hide_secrets_test {
namespace {

TEST(HideSecrets, hides_queries_and_users_wherever_an_address_stands) {
  for (const auto& [text, expected] : {
           std::pair{"no address, but a question?", "no address, but a question?"},
           {"https://h/x?Signature=S: is not there", "https://h/x?...: is not there"},
           {"\"s3://b?S\" and ws://h:1/live/a?token=S, both",
            "\"s3://b?...\" and ws://h:1/live/a?..., both"},
           {"http://me:secret@h:80/x", "http://h:80/x"},
           {"(http://me:secret@h/x?S#f).", "(http://h/x?...)."},
           {"http://me:se?cret@h/x", "http://?..."},
           {"http://h/a@b", "http://h/a@b"},
           {"http://h?S", "http://h?..."},
           {"http://h/x.", "http://h/x."},
           {"http://", "http://"},
           {"://?S", "://?..."},
       }) {
    const std::string hidden = hide_secrets(text);
    EXPECT_EQ(hidden, expected);
    EXPECT_EQ(hide_secrets(hidden), hidden);
  }
}

}  // namespace
}  // namespace pointreel::hide_secrets_test
