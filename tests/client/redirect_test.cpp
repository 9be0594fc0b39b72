#include "common/http/redirect.h"

#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/source/open_source.h"
#include "tests/scripted_http_server.h"

namespace pointreel::redirect_test {
namespace {

using testing::HasSubstr;
using Verdict = Redirect::Verdict;

Verdict verdict(const std::string& from, const std::string& location, bool to_other_hosts = false) {
  return judge_redirect(from, location, to_other_hosts).verdict;
}

TEST(Redirect, stays_on_its_host_whatever_the_path_and_port) {
  const std::string from = "http://reels.example/walk/reel.json";
  for (const char* location :
       {"other.json", "/x", "?y", "http://reels.example/x", "HTTP://REELS.EXAMPLE/x",
        "http://reels.example:8090/x", "https://reels.example/x", "//reels.example/x"})
    EXPECT_EQ(verdict(from, location), Verdict::follow) << location;
}

TEST(Redirect, leads_to_another_host_only_where_that_is_allowed) {
  const std::string from = "http://reels.example/walk/reel.json";
  for (const char* location :
       {"http://evil.example/", "//evil.example/x", "http://reels.example.evil.example/",
        "http://reels.example@evil.example/", "http://127.0.0.1/", "http://[::1]/",
        "https://evil.example/"}) {
    EXPECT_EQ(verdict(from, location), Verdict::another_host) << location;
    EXPECT_EQ(verdict(from, location, true), Verdict::follow) << location;
  }
}

TEST(Redirect, to_what_is_not_an_address_of_http_is_refused) {
  for (const char* location :
       {"http://", "http://[", "http:///x y", "http://a b/", "file:///etc/passwd", "ftp://a/b"})
    EXPECT_EQ(verdict("http://reels.example/", location, true), Verdict::not_http) << location;
}

TEST(Redirect, never_leads_from_https_to_anything_less) {
  for (const char* location : {"http://reels.example/", "http://evil.example/",
                               "ftp://reels.example/", "file:///etc/passwd"}) {
    EXPECT_EQ(verdict("https://reels.example/x", location), Verdict::not_secure) << location;
    EXPECT_EQ(verdict("https://reels.example/x", location, true), Verdict::not_secure) << location;
  }
  EXPECT_EQ(verdict("https://reels.example/x", "/y"), Verdict::follow);
}

/// A server that redirects every request.
ScriptedHttpServer::Handler redirect_to(const std::string& location) {
  return [location](int socket, const std::string&) {
    answer(socket, "302 Found", "Location: " + location + "\r\n", "");
    return true;
  };
}

ScriptedHttpServer::Handler no_package() {
  return [](int socket, const std::string&) {
    answer(socket, "200 OK", "", "{}");
    return true;
  };
}

TEST(HttpSource, a_redirect_to_another_host_is_refused_before_that_host_is_asked) {
  ScriptedHttpServer target(no_package());
  const std::string port = target.url().substr(target.url().rfind(':'));
  ScriptedHttpServer server(redirect_to("http://localhost" + port + "/reel.json"));
  const auto source = open_source(server.url() + "/walk");
  ASSERT_FALSE(source);
  EXPECT_THAT(source.error().message,
              HasSubstr("redirects to another host, http://localhost" + port));
  EXPECT_THAT(source.error().message, HasSubstr("--follow-redirects"));
  EXPECT_EQ(target.connections, 0);
  EXPECT_EQ(server.requests, 1);

  SourceOptions follow;
  follow.follow_redirects = true;
  EXPECT_FALSE(open_source(server.url() + "/walk", follow));
  EXPECT_EQ(target.requests, 1);
}

TEST(HttpSource, a_redirect_to_what_is_not_http_is_refused_without_advice_to_follow_it) {
  ScriptedHttpServer server(redirect_to("file:///etc/passwd"));
  SourceOptions follow;
  follow.follow_redirects = true;
  for (const SourceOptions& options : {SourceOptions{}, follow}) {
    const auto source = open_source(server.url() + "/walk", options);
    ASSERT_FALSE(source);
    EXPECT_THAT(source.error().message, HasSubstr("redirects to file:///etc/passwd, which is not"));
    EXPECT_THAT(source.error().message, testing::Not(HasSubstr("--follow-redirects")));
  }
}

TEST(HttpSource, says_that_a_server_may_use_tls_if_it_does_not_answer) {
  const auto hangs_up = [](int, const std::string&) { return false; };
  const auto resets = [](int socket, const std::string&) {
    sockaddr nobody{};
    nobody.sa_family = AF_UNSPEC;
    ::connect(socket, &nobody, sizeof nobody);
    return false;
  };
  for (const ScriptedHttpServer::Handler& handler :
       {ScriptedHttpServer::Handler(hangs_up), ScriptedHttpServer::Handler(resets)}) {
    ScriptedHttpServer server(handler);
    SourceOptions options;
    options.open_attempts = 1;
    const auto source = open_source(server.url() + "/walk", options);
    ASSERT_FALSE(source);
    EXPECT_THAT(source.error().message, HasSubstr("if it uses TLS, use https://"));
  }
}

TEST(HttpSource, a_redirect_to_another_port_of_the_host_is_followed) {
  ScriptedHttpServer target(no_package());
  ScriptedHttpServer server(redirect_to(target.url() + "/reel.json"));
  EXPECT_FALSE(open_source(server.url() + "/walk"));
  EXPECT_EQ(target.requests, 1);
}

}  // namespace
}  // namespace pointreel::redirect_test
