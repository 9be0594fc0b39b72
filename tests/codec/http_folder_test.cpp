// Addresses of packages.

#include "codec/package/http_folder.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/net/url.h"

namespace pointreel::http_folder_test {
namespace {

using testing::HasSubstr;

const Store kStore = {"http://127.0.0.1:9000", {"AKID", "hush", "", "us-east-1"}};

std::string base_of(const std::string& address) {
  const auto folder = parse_store_folder(address, kStore);
  return folder ? folder->base : folder.error().message;
}

TEST(HttpFolder, an_object_is_asked_for_by_bucket_and_key) {
  EXPECT_EQ(base_of("s3://reels/walk"), "http://127.0.0.1:9000/reels/walk");
  EXPECT_EQ(base_of("s3://reels/a/b/reel.json"), "http://127.0.0.1:9000/reels/a/b");
  EXPECT_EQ(base_of("s3://reels/walk//"), "http://127.0.0.1:9000/reels/walk");
  EXPECT_EQ(parse_store_folder("s3://reels/walk", kStore)->manifest(),
            "http://127.0.0.1:9000/reels/walk/reel.json");
  EXPECT_EQ(parse_store_folder("s3://reels/walk", kStore)->access->key_id, "AKID");
}

TEST(HttpFolder, keys_are_percent_encoded) {
  EXPECT_EQ(base_of("s3://reels/a b/x=1?y#z%é+"),
            "http://127.0.0.1:9000/reels/a%20b/x%3D1%3Fy%23z%25%C3%A9%2B");
}

TEST(HttpFolder, what_no_store_has_is_refused) {
  EXPECT_THAT(base_of("s3://"), HasSubstr("names no bucket"));
  EXPECT_THAT(base_of("s3:///walk"), HasSubstr("names no bucket"));
  EXPECT_THAT(base_of("s3://re els/walk"), HasSubstr("names no bucket"));
  EXPECT_THAT(base_of("s3://reels"), HasSubstr("no package in it"));
  EXPECT_THAT(base_of("s3://reels/reel.json"), HasSubstr("no package in it"));
  EXPECT_THAT(base_of("s3://reels/a/../b"), HasSubstr("\"..\""));
  EXPECT_THAT(base_of("s3://reels/a//b"), HasSubstr("empty"));
  EXPECT_THAT(base_of("s3://reels/a\nb"), HasSubstr("control character"));
  EXPECT_THAT(base_of("s3://reels/" + std::string(2000, 'a')), HasSubstr("too long"));
}

TEST(HttpFolder, printed_addresses_have_no_secrets) {
  EXPECT_EQ(without_secrets("https://host/reel/reel.json?Signature=abc&x=?#t"),
            "https://host/reel/reel.json?...");
  EXPECT_EQ(without_secrets("https://me:pass@host/a@b"), "https://host/a@b");
  EXPECT_EQ(without_secrets("https://me:pass@host"), "https://host");
  EXPECT_EQ(without_secrets("https://host/reel"), "https://host/reel");
  EXPECT_EQ(without_secrets("folder/what?.reel"), "folder/what?.reel");
}

}  // namespace
}  // namespace pointreel::http_folder_test
