// Where the keys of an object store are found.

#include "common/http/aws_access.h"

#include <map>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/http/aws_files.h"
#include "common/http/store_error.h"
#include "tests/temporary_folder.h"

namespace pointreel::aws_access_test {
namespace {

using testing::HasSubstr;
using testing::Not;
using Variables = std::map<std::string, std::string>;

Environment environment_of(Variables variables) {
  return [variables = std::move(variables)](const char* name) -> std::optional<std::string> {
    const auto found = variables.find(name);
    return found == variables.end() ? std::nullopt : std::optional(found->second);
  };
}

Result<Store> store_of(Variables variables, const std::string& endpoint = "") {
  return resolve_store(endpoint, environment_of(std::move(variables)));
}

std::string error_of(Variables variables, const std::string& endpoint = "") {
  const auto store = store_of(std::move(variables), endpoint);
  return store ? "none" : store.error().message;
}

const Variables kKeys = {{"AWS_ACCESS_KEY_ID", "AKID"}, {"AWS_SECRET_ACCESS_KEY", "hush"}};

Variables with(Variables more) {
  more.insert(kKeys.begin(), kKeys.end());
  return more;
}

constexpr const char* kCredentials = R"(
# keys
[default]
aws_access_key_id = DEFAULT
aws_secret_access_key=secret/of+default=

[work]
  aws_access_key_id = of the line above, not a key
aws_access_key_id = WORK
aws_secret_access_key = secret-of-work
aws_session_token = token
)";

constexpr const char* kConfig = R"([default]
region = eu-west-1
[profile work]
region=eu-central-1
endpoint_url = http://127.0.0.1:9000/
s3 =
  region = nowhere
[work]
region = not-a-profile
)";

TEST(AwsAccess, keys_of_the_environment_are_enough) {
  const auto store = store_of(with({{"AWS_SESSION_TOKEN", "token"}}));
  ASSERT_TRUE(store) << store.error().message;
  EXPECT_EQ(store->access.key_id, "AKID");
  EXPECT_EQ(store->access.secret, "hush");
  EXPECT_EQ(store->access.session_token, "token");
  EXPECT_EQ(store->access.region, "us-east-1");
  EXPECT_EQ(store->endpoint, "https://s3.us-east-1.amazonaws.com");
}

TEST(AwsAccess, profiles_are_read_from_both_files) {
  TemporaryFolder home;
  home.write(".aws/credentials", kCredentials);
  home.write(".aws/config", kConfig);
  const auto usual = store_of({{"HOME", home.path().string()}});
  ASSERT_TRUE(usual) << usual.error().message;
  EXPECT_EQ(usual->access.key_id, "DEFAULT");
  EXPECT_EQ(usual->access.secret, "secret/of+default=");
  EXPECT_EQ(usual->access.session_token, "");
  EXPECT_EQ(usual->endpoint, "https://s3.eu-west-1.amazonaws.com");

  const auto work = store_of({{"HOME", home.path().string()}, {"AWS_PROFILE", "work"}});
  ASSERT_TRUE(work) << work.error().message;
  EXPECT_EQ(work->access.key_id, "WORK");
  EXPECT_EQ(work->access.secret, "secret-of-work");
  EXPECT_EQ(work->access.session_token, "token");
  EXPECT_EQ(work->access.region, "eu-central-1");
  EXPECT_EQ(work->endpoint, "http://127.0.0.1:9000");
}

TEST(AwsAccess, the_environment_goes_before_the_files_and_an_option_before_both) {
  TemporaryFolder home;
  const Variables variables = with({{"AWS_SHARED_CREDENTIALS_FILE", home.write("c", kCredentials)},
                                    {"AWS_CONFIG_FILE", home.write("f", kConfig)},
                                    {"AWS_PROFILE", "work"},
                                    {"AWS_REGION", "ap-south-1"},
                                    {"AWS_ENDPOINT_URL", "http://one.example"},
                                    {"AWS_ENDPOINT_URL_S3", "http://two.example"}});
  const auto store = store_of(variables);
  ASSERT_TRUE(store) << store.error().message;
  EXPECT_EQ(store->access.key_id, "AKID");
  EXPECT_EQ(store->access.session_token, "") << "a token of other keys";
  EXPECT_EQ(store->access.region, "ap-south-1");
  EXPECT_EQ(store->endpoint, "http://two.example");
  EXPECT_EQ(store_of(variables, "https://three.example/path/")->endpoint,
            "https://three.example/path");
}

TEST(AwsAccess, keys_in_the_credentials_get_no_token_of_the_config) {
  TemporaryFolder home;
  home.write(".aws/credentials", "[default]\naws_access_key_id=A\naws_secret_access_key=B\n");
  home.write(".aws/config", "[default]\naws_session_token=C\n");
  EXPECT_EQ(store_of({{"HOME", home.path().string()}})->access.session_token, "");
}

TEST(AwsAccess, what_is_missing_is_named) {
  EXPECT_THAT(error_of({}), HasSubstr("set AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY"));
  EXPECT_THAT(error_of({{"AWS_ACCESS_KEY_ID", "A"}}), HasSubstr("AWS_SECRET_ACCESS_KEY is not"));
  EXPECT_THAT(error_of(with({{"AWS_PROFILE", "other"}})), HasSubstr("has a profile \"other\""));
  EXPECT_THAT(error_of(with({{"AWS_SHARED_CREDENTIALS_FILE", "/nowhere/keys"}})),
              HasSubstr("/nowhere/keys: is not a file"));
  EXPECT_THAT(error_of(with({{"AWS_REGION", "eu central"}})), HasSubstr("name of a region"));
  EXPECT_THAT(error_of(kKeys, "s3.example.org"), HasSubstr("is not an address"));
  EXPECT_THAT(error_of(kKeys, "ftp://example.org"), HasSubstr("the endpoint of a store"));
  EXPECT_THAT(error_of(kKeys, "http://me:pass@example.org"), Not(HasSubstr("pass@")));
}

TEST(AwsAccess, keys_that_would_break_a_request_are_refused_and_not_shown) {
  const std::string error =
      error_of({{"AWS_ACCESS_KEY_ID", "A"}, {"AWS_SECRET_ACCESS_KEY", "hush\r\nX-Header: 1"}});
  EXPECT_THAT(error, HasSubstr("no key has"));
  EXPECT_THAT(error, Not(HasSubstr("hush")));
}

TEST(StoreError, the_code_is_found_where_there_is_one) {
  EXPECT_EQ(store_error_code("<?xml version=\"1.0\"?>\n<Error><Code>SlowDown</Code>"), "SlowDown");
  EXPECT_EQ(store_error_code("<Error>\n <Message>a</Message>\n <Code>A1</Code></Error>"), "A1");
  for (const char* damaged :
       {"", "<Code>SlowDown</Code>", "<Error><Code>SlowDown", "<Error><Code></Code>",
        "<Error><Code>a b</Code>", "<Error><Code>\x1b[2J</Code>", "<Error><Code>x<</Code>"})
    EXPECT_EQ(store_error_code(damaged), "") << damaged;
  EXPECT_EQ(store_error_code("<Error><Code>" + std::string(65, 'a') + "</Code>"), "");
}

}  // namespace
}  // namespace pointreel::aws_access_test
