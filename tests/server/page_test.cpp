// The page that browsers get from the server, and what programs get at the same addresses.

#include "server/service/page.h"

#include <array>
#include <string>
#include <string_view>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/relay/relay.h"
#include "server/service/negotiation.h"
#include "server/service/origin.h"
#include "tests/server/http_server_test.h"

namespace pointreel::page_test {
namespace {

using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;
using Answer = RawHttpClient::Answer;

constexpr std::array<PageFile, 2> kFiles = {{
    {"index.html", "<!doctype html>", "brotli page", "gzip page"},
    {"ABC/player.wasm", "plain module", "brotli module", ""},
}};
const std::string kBrowser = "Accept: text/html,application/xhtml+xml,*/*;q=0.8\r\n";

class PageTest : public HttpServerTest {
 protected:
  void start_with_page(const std::string& view_token = {}) {
    HttpServerOptions options;
    options.service.page = Page(kFiles);
    options.service.view_token = view_token;
    start(options);
  }
};

TEST(Negotiation, finds_what_a_browser_names_and_does_not_refuse) {
  EXPECT_TRUE(names_acceptable("text/html", "text/html"));
  EXPECT_TRUE(names_acceptable("a/b ; x=1 , TEXT/html;q=0.01", "text/html"));
  EXPECT_TRUE(names_acceptable("gzip, deflate, br, zstd", "br"));
  EXPECT_TRUE(names_acceptable("br;q=1.0", "br"));
  EXPECT_FALSE(names_acceptable("br;q=0", "br"));
  EXPECT_FALSE(names_acceptable("br ; Q = 0.000, gzip", "br"));
  EXPECT_FALSE(names_acceptable("*/*", "text/html"));
  EXPECT_FALSE(names_acceptable("brx, xbr", "br"));
  EXPECT_FALSE(names_acceptable("", "br"));
  EXPECT_FALSE(names_acceptable(",;,=;q", "br"));
}

TEST_F(PageTest, gives_browsers_the_page_where_programs_get_data) {
  start_with_page();
  for (const char* target : {"/", "/walk", "/?reel=walk"}) {
    const Answer page = get(target, kBrowser);
    EXPECT_EQ(page.status, 200) << target;
    EXPECT_EQ(page.body, "<!doctype html>") << target;
    EXPECT_EQ(page.field("content-type"), "text/html; charset=utf-8");
    EXPECT_EQ(page.field("cache-control"), "no-cache");
    EXPECT_THAT(page.field("vary"), HasSubstr("Accept"));
    EXPECT_THAT(page.field("content-security-policy"), StartsWith("default-src 'none';"));
  }
  const Answer slash = get("/walk/", kBrowser);
  EXPECT_EQ(slash.status, 308);
  EXPECT_EQ(slash.field("location"), "/walk");

  const Answer list = get("/");
  EXPECT_EQ(list.field("content-type"), "application/json");
  EXPECT_THAT(list.field("vary"), HasSubstr("Accept"));
  EXPECT_EQ(get("/", "Accept: */*\r\n").field("content-type"), "application/json");
  const Answer redirect = get("/walk");
  EXPECT_EQ(redirect.field("location"), "/walk/reel.json");
  EXPECT_THAT(redirect.field("vary"), HasSubstr("Accept"));
  // Data and what is for people stay what they are.
  EXPECT_EQ(get("/walk/reel.json", kBrowser).field("content-type"), "application/json");
  EXPECT_EQ(get("/healthz", kBrowser).body, "ok\n");
  EXPECT_EQ(get("/missing", kBrowser).status, 404);
}

TEST_F(PageTest, may_be_framed_by_pages_of_the_server_and_by_others_that_are_named) {
  start_with_page();
  EXPECT_THAT(get("/", kBrowser).field("content-security-policy"),
              EndsWith("; frame-ancestors 'self'"));
  HttpServerOptions options;
  options.service.page =
      Page(kFiles, parse_frame_ancestors({"https://Example.org:8443", "http://a.b"}).value());
  start(options);
  EXPECT_THAT(get("/", kBrowser).field("content-security-policy"),
              EndsWith("; frame-ancestors 'self' https://example.org:8443 http://a.b"));
  EXPECT_EQ(parse_frame_ancestors({"*"}).value(), "'self' *");
  for (const char* none : {"example.org", "https://a.b/c", "https://a;script-src", ""})
    EXPECT_FALSE(parse_frame_ancestors({none})) << none;
}

TEST_F(PageTest, sends_the_form_that_the_browser_understands_best) {
  start_with_page();
  const Answer brotli = get("/", kBrowser + "Accept-Encoding: gzip, deflate, br\r\n");
  EXPECT_EQ(brotli.body, "brotli page");
  EXPECT_EQ(brotli.field("content-encoding"), "br");
  const Answer gzip = get("/", kBrowser + "Accept-Encoding: gzip, br;q=0\r\n");
  EXPECT_EQ(gzip.body, "gzip page");
  EXPECT_EQ(gzip.field("content-encoding"), "gzip");
  EXPECT_NE(gzip.field("etag"), brotli.field("etag"));
  const Answer module = get("/page/ABC/player.wasm", "Accept-Encoding: br\r\n");
  EXPECT_EQ(module.body, "brotli module");
  EXPECT_EQ(module.field("content-type"), "application/wasm");
  EXPECT_EQ(module.field("cache-control"), "public, max-age=31536000, immutable");
  EXPECT_EQ(module.field("vary"), "Accept-Encoding");
  const Answer plain = get("/page/ABC/player.wasm", "Accept-Encoding: gzip\r\n");
  EXPECT_EQ(plain.body, "plain module");
  EXPECT_EQ(plain.field("content-encoding"), "");
  EXPECT_EQ(get("/live/page/ABC/player.wasm").body, "plain module");
  EXPECT_EQ(get("/page/other.js").status, 404);
}

TEST_F(PageTest, gives_the_page_without_a_token_but_nothing_else) {
  start_with_page("secret");
  EXPECT_EQ(get("/walk", kBrowser).status, 200);
  EXPECT_EQ(get("/page/ABC/player.wasm").status, 200);
  EXPECT_EQ(get("/missing", kBrowser).body, "<!doctype html>") << "nobody learns which reels exist";
  for (const char* target : {"/", "/walk", "/walk/reel.json", "/metrics", "/missing"}) {
    EXPECT_EQ(get(target).status, 401) << target;
  }
  EXPECT_EQ(get("/metrics", kBrowser).status, 401);
  EXPECT_EQ(get("/walk/reel.json", "Authorization: Bearer secret\r\n").status, 200);
}

TEST_F(PageTest, gives_browsers_data_if_there_is_no_page) {
  start();
  const Answer list = get("/", kBrowser);
  EXPECT_EQ(list.field("content-type"), "application/json");
  EXPECT_EQ(list.field("vary"), "");
  EXPECT_EQ(get("/walk", kBrowser).status, 308);
}

TEST(LivePage, takes_the_token_of_a_browser_from_the_subprotocols) {
  Relay relay;
  ServiceOptions options;
  options.log = Log::Level::kOff;
  options.view_token = "a b/c=,%";
  options.page = Page(kFiles);
  Service service(*Catalog::load({}), &relay, options);
  const auto call = [&](const std::string& protocols) {
    Request request;
    request.method = "GET";
    request.target = "/live/alice";
    request.host = "localhost";
    request.host_fields = 1;
    request.websocket = true;
    request.protocols = protocols;
    return service.answer(request, Peer(), [] {});
  };
  const auto status = [&](const std::string& protocols) {
    const auto answer = call(protocols);
    return std::holds_alternative<LiveCall>(answer) ? 101 : std::get<Response>(answer).status;
  };
  EXPECT_EQ(status(""), 401);
  EXPECT_EQ(status("pointreel, bearer.wrong"), 401);
  EXPECT_EQ(status("pointreel, bearer.a%20b%2Fc%3D%2C%2"), 401);
  // The right token gets past the check: there is no such stream.
  EXPECT_EQ(status("pointreel, bearer.a%20b%2Fc%3D%2C%25"), 404);
  EXPECT_EQ(status("bearer.a%20b%2fc%3d%2c%25 ,pointreel"), 404);
}

}  // namespace
}  // namespace pointreel::page_test
