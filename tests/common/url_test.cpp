#include "common/net/url.h"

#include <gtest/gtest.h>

namespace pointreel::url_test {
namespace {

TEST(Url, is_taken_apart) {
  const auto url = parse_url("HTTPS://me:secret@host:8090/reel?x=1#there");
  ASSERT_TRUE(url) << url.error().message;
  EXPECT_EQ(url->scheme, "https");
  EXPECT_EQ(url->user, "me:secret");
  EXPECT_EQ(url->host, "host");
  EXPECT_EQ(url->port, 8090);
  EXPECT_EQ(url->target, "/reel?x=1");
  EXPECT_TRUE(url->is_http());
  EXPECT_FALSE(url->is_websocket());
  EXPECT_TRUE(url->tls());
  EXPECT_EQ(url->place(), "host:8090");
}

TEST(Url, tokens_must_not_break_a_request) {
  EXPECT_TRUE(check_token(""));
  EXPECT_TRUE(check_token("a-B_7.~+/="));
  for (const char* bad : {"a b", "a\r\nX: 1", "\t", "\x7f"}) EXPECT_FALSE(check_token(bad)) << bad;
}

TEST(Url, has_the_port_of_its_scheme_unless_it_names_one) {
  EXPECT_EQ(parse_url("http://host/reel")->port, 80);
  EXPECT_EQ(parse_url("https://host/reel")->port, 443);
  EXPECT_EQ(parse_url("ws://host/reel")->port, 80);
  EXPECT_EQ(parse_url("wss://host/reel")->port, 443);
  EXPECT_EQ(parse_url("wss://host:1/reel")->port, 1);
}

TEST(Url, has_a_target_even_without_a_path) {
  EXPECT_EQ(parse_url("http://host")->target, "/");
  EXPECT_EQ(parse_url("http://host?query")->target, "/?query");
  EXPECT_EQ(parse_url("http://host#fragment")->target, "/");
}

TEST(Url, writes_ipv6_addresses_in_brackets) {
  const auto url = parse_url("http://[::1]:81/reel");
  ASSERT_TRUE(url);
  EXPECT_EQ(url->host, "::1");
  EXPECT_EQ(url->place(), "[::1]:81");
}

TEST(Url, is_refused_if_it_is_malformed) {
  for (const char* wrong :
       {"", "reel", "/reel", "://host/", "http://", "http://:80/", "http://host:0/",
        "http://host:65536/", "http://host:8o/", "http://[::1/", "http://[::1]x/", "http://a b/",
        "http://host/a\r\nX: y"}) {
    const auto url = parse_url(wrong);
    ASSERT_FALSE(url) << wrong;
    EXPECT_EQ(url.error().code, ErrorCode::argument);
    EXPECT_TRUE(url.error().message.starts_with(wrong));
  }
}

TEST(Url, differs_from_a_path_by_its_scheme) {
  EXPECT_EQ(scheme_of("ftp://host/file"), "ftp");
  EXPECT_EQ(scheme_of("/folder/file"), "");
  EXPECT_EQ(scheme_of("C:/folder"), "");
}

}  // namespace
}  // namespace pointreel::url_test
