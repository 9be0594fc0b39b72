// Pointreel's use of HTTP without a socket: ranges, entity tags, request targets, addresses.

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/serve/listen_address.h"
#include "server/service/entity_tag.h"
#include "server/service/range_header.h"
#include "server/service/request_target.h"
#include "server/service/responder.h"

namespace pointreel::http_logic_test {
namespace {

using Kind = RangeAnswer::Kind;

TEST(RangeHeader, is_answered_according_to_rfc_9110) {
  struct Case {
    const char* field;
    std::uint64_t size;
    RangeAnswer answer;
  };
  const RangeAnswer whole{}, no{Kind::kUnsatisfiable};
  const auto part = [](std::uint64_t offset, std::uint64_t size) {
    return RangeAnswer{Kind::kPart, offset, size};
  };
  const std::vector<Case> cases = {
      // One range.
      {"bytes=0-0", 100, part(0, 1)},
      {"bytes=0-99", 100, part(0, 100)},
      {"bytes=10-19", 100, part(10, 10)},
      {"bytes=99-99", 100, part(99, 1)},
      {"bytes=90-1000", 100, part(90, 10)},
      {"bytes=0-", 100, part(0, 100)},
      {"bytes=42-", 100, part(42, 58)},
      {"bytes=-1", 100, part(99, 1)},
      {"bytes=-100", 100, part(0, 100)},
      {"bytes=-101", 100, part(0, 100)},
      {"bytes=007-8", 100, part(7, 2)},
      {"BYTES=1-2", 100, part(1, 2)},
      {" bytes = 1-2 ", 100, part(1, 2)},
      // Past the end.
      {"bytes=100-", 100, no},
      {"bytes=100-100", 100, no},
      {"bytes=-0", 100, no},
      {"bytes=0-", 0, no},
      {"bytes=0-0", 0, no},
      {"bytes=-5", 0, no},
      // Numbers beyond 64 bits.
      {"bytes=0-99999999999999999999999", 100, part(0, 100)},
      {"bytes=-99999999999999999999999", 100, part(0, 100)},
      {"bytes=99999999999999999999999-", 100, no},
      {"bytes=18446744073709551615-", 100, no},
      {"bytes=0-18446744073709551615", 100, part(0, 100)},
      {"bytes=18446744073709551616-18446744073709551617", 100, no},
      // Malformed or several ranges are ignored, as if the field were missing.
      {"", 100, whole},
      {"bytes", 100, whole},
      {"bytes=", 100, whole},
      {"bytes=-", 100, whole},
      {"bytes=--1", 100, whole},
      {"bytes=5", 100, whole},
      {"bytes=9-3", 100, whole},
      {"bytes=a-b", 100, whole},
      {"bytes=0x1-2", 100, whole},
      {"bytes=1 -2", 100, whole},
      {"bytes=+1-2", 100, whole},
      {"bytes=1-2-3", 100, whole},
      {"bytes=1-2,4-5", 100, whole},
      {"bytes=-1,-2", 100, whole},
      {"bytes 1-2", 100, whole},
      {"lines=1-2", 100, whole},
      {"xbytes=1-2", 100, whole},
      {"=1-2", 100, whole},
  };
  for (const Case& c : cases) {
    EXPECT_EQ(answer_range(c.field, c.size), c.answer) << c.field << " of " << c.size;
  }
}

TEST(EntityTag, is_the_checksum_in_sixteen_digits) {
  EXPECT_EQ(make_etag(0), "\"0000000000000000\"");
  EXPECT_EQ(make_etag(0xfedcba9876543210), "\"fedcba9876543210\"");
}

TEST(EntityTag, matches_lists_of_tags_weakly_and_strongly) {
  struct Case {
    const char* list;
    bool weakly, strongly;
  };
  const std::string tag = "\"abc\"";
  const std::vector<Case> cases = {
      {"\"abc\"", true, true},
      {"*", true, true},
      {" * ", true, true},
      {"\"x\", \"abc\"", true, true},
      {"\"x\",\"abc\",\"y\"", true, true},
      {",, \"abc\"", true, true},
      {"\"a,b\", \"abc\"", true, true},
      {"W/\"abc\"", true, false},
      {"W/\"x\", W/\"abc\"", true, false},
      {"W/\"abc\", \"abc\"", true, true},
      {"", false, false},
      {"abc", false, false},
      {"\"abc", false, false},
      {"\"ABC\"", false, false},
      {"\"ab\"", false, false},
      {"\"abcd\"", false, false},
      {"\"x,\"abc\"", false, false},
      {"\"x\" \"abc\"", false, false},
      {"w/\"abc\"", false, false},
      {"**", false, false},
      {"*, \"x\"", false, false},
      {"Sun, 06 Nov 1994 08:49:37 GMT", false, false},
  };
  for (const Case& c : cases) {
    EXPECT_EQ(matches_weakly(c.list, tag), c.weakly) << c.list;
    EXPECT_EQ(matches_strongly(c.list, tag), c.strongly) << c.list;
  }
}

TEST(RequestTarget, is_percent_decoded_exactly_once) {
  const std::vector<std::pair<const char*, const char*>> cases = {
      {"/", "/"},
      {"/a", "/a"},
      {"/a/", "/a/"},
      {"/a/b.seg", "/a/b.seg"},
      {"/a?x=/../..", "/a"},
      {"/a?", "/a"},
      {"/%41%62%2e%63", "/Ab.c"},
      {"/a%20b", "/a b"},
      {"/%C3%a4", "/\xC3\xA4"},
      {"/a%3Fb", "/a?b"},
      {"/%252e%252e/x", "/%2e%2e/x"},
      {"/...", "/..."},
      {"/.a/..b", "/.a/..b"},
      {"//", "//"},
      {"http://host", "/"},
      {"http://host/", "/"},
      {"http://host?q", "/"},
      {"HTTP://host:80/a/b?q", "/a/b"},
  };
  for (const auto& [target, path] : cases) {
    const auto decoded = decode_target(target);
    ASSERT_TRUE(decoded) << target << ": " << decoded.error().message;
    EXPECT_EQ(*decoded, path) << target;
  }
}

TEST(RequestTarget, is_refused_if_it_leaves_the_root_or_names_hidden_files) {
  const std::vector<std::string> cases = {
      "",
      "*",
      "a",
      "a/b",
      "..",
      "host:443",
      "https://host/a",
      "ftp://host/a",
      "http:/a",
      // Dot segments.
      "/..",
      "/../",
      "/.",
      "/./a",
      "/a/..",
      "/a/../b",
      "/a/.",
      "/../../etc/passwd",
      "/%2e%2e/a",
      "/%2E%2e",
      "/.%2e/a",
      "/%2e./a",
      "/a/%2e",
      "http://host/../a",
      // Separators that hide inside a segment.
      "/a%2fb",
      "/a%2F..%2Fb",
      "/..%2f",
      "/a\\b",
      "/..\\..",
      "/%5c",
      "/a%5C..",
      // Control characters.
      "/a%00",
      "/%00",
      "/a%0ab",
      "/%0d%0a",
      "/%7f",
      std::string("/a\0b", 4),
      "/a\tb",
      // Malformed.
      "/%",
      "/%4",
      "/%4g",
      "/%%41",
      "/a#b",
      "/%-1",
      "/%+1",
      "/% 1",
  };
  for (const std::string& target : cases) {
    const auto decoded = decode_target(target);
    EXPECT_FALSE(decoded) << target << " became " << *decoded;
  }
}

TEST(RequestTarget, is_restored_from_an_encoded_segment) {
  for (const std::string name : {"liam", "a b", "50%", "a?b#c", "\xC3\xA4", "x+y&z", "-._~"}) {
    const auto decoded = decode_target("/" + encode_segment(name));
    ASSERT_TRUE(decoded) << name;
    EXPECT_EQ(*decoded, "/" + name);
  }
  EXPECT_EQ(encode_segment("a b/\xC3"), "a%20b%2F%C3");
}

TEST(ListenAddress, consists_of_a_numeric_address_and_a_port) {
  EXPECT_EQ(parse_listen_address("127.0.0.1:8090"), (ListenAddress{"127.0.0.1", 8090}));
  EXPECT_EQ(parse_listen_address("0.0.0.0:0"), (ListenAddress{"0.0.0.0", 0}));
  EXPECT_EQ(parse_listen_address("[::1]:65535"), (ListenAddress{"::1", 65535}));
  EXPECT_EQ(parse_listen_address("localhost:80"), (ListenAddress{"127.0.0.1", 80}));
  for (const char* text :
       {"", ":", ":80", "80", "127.0.0.1", "127.0.0.1:", "127.0.0.1:x", "127.0.0.1:65536",
        "127.0.0.1:-1", "127.0.0.1: 80", "127.0.0.1:80 ", "127.0.0:80", "256.0.0.1:80", "::1:80",
        "[::1]", "[::1]80", "[127.0.0.1]:80", "example.org:80", "[localhost]:80"}) {
    const auto address = parse_listen_address(text);
    ASSERT_FALSE(address) << text;
    EXPECT_THAT(address.error().message, testing::HasSubstr("--listen"));
  }
}

TEST(ListenAddress, is_formatted_as_in_a_url) {
  EXPECT_EQ(to_string(ListenAddress{"127.0.0.1", 80}), "127.0.0.1:80");
  EXPECT_EQ(to_string(ListenAddress{"::1", 8090}), "[::1]:8090");
}

TEST(ResponseHead, has_the_date_in_http_format) {
  EXPECT_EQ(http_date(784111777), "Sun, 06 Nov 1994 08:49:37 GMT");
  EXPECT_EQ(http_date(0), "Thu, 01 Jan 1970 00:00:00 GMT");
  EXPECT_EQ(http_date(1709208000), "Thu, 29 Feb 2024 12:00:00 GMT");
}

TEST(ResponseHead, ends_with_one_empty_line_and_states_whether_the_connection_persists) {
  const std::string kept = write_head(error_response(404, "no"), true, 0);
  EXPECT_TRUE(kept.starts_with("HTTP/1.1 404 Not Found\r\n")) << kept;
  EXPECT_THAT(kept, testing::HasSubstr("\r\nConnection: keep-alive\r\n"));
  EXPECT_THAT(kept, testing::HasSubstr("\r\nContent-Length: 3\r\n"));
  EXPECT_EQ(kept.find("\r\n\r\n"), kept.size() - 4);
  EXPECT_THAT(write_head(error_response(404, "no"), false, 0),
              testing::HasSubstr("\r\nConnection: close\r\n"));
}

}  // namespace
}  // namespace pointreel::http_logic_test
