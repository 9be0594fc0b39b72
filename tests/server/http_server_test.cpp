// The server's responses to all kinds of requests.

#include "tests/server/http_server_test.h"

#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codec/package/manifest.h"

namespace pointreel::http_server_test {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::StartsWith;
using Answer = RawHttpClient::Answer;

TEST_F(HttpServerTest, serves_whole_files_with_all_fields_that_caches_and_browsers_need) {
  start();
  const Answer answer = get("/walk/0.full.prs");
  EXPECT_EQ(answer.status, 200);
  EXPECT_TRUE(answer.body == full_);
  EXPECT_EQ(answer.field("content-type"), "application/octet-stream");
  EXPECT_EQ(answer.field("content-length"), "700001");
  EXPECT_EQ(answer.field("etag"), make_etag(checksum_of_text(full_)));
  EXPECT_EQ(answer.field("cache-control"), "public, max-age=31536000, immutable");
  EXPECT_EQ(answer.field("accept-ranges"), "bytes");
  EXPECT_EQ(answer.field("access-control-allow-origin"), "");
  EXPECT_EQ(answer.field("cross-origin-resource-policy"), "same-origin");
  EXPECT_EQ(answer.field("x-content-type-options"), "nosniff");
  EXPECT_EQ(answer.field("server"), "pointreel");
  EXPECT_THAT(answer.field("date"), testing::EndsWith(" GMT"));
}

TEST_F(HttpServerTest, serves_the_manifest_the_listing_and_its_health) {
  start();
  const Answer manifest = get("/walk/reel.json");
  EXPECT_EQ(manifest.status, 200);
  EXPECT_EQ(manifest.body, write_manifest(small_manifest(base_, full_)));
  EXPECT_EQ(manifest.field("content-type"), "application/json");
  EXPECT_EQ(manifest.field("cache-control"), "no-cache");
  EXPECT_EQ(manifest.field("etag"), make_etag(checksum_of_text(manifest.body)));
  const Answer listing = get("/?x=y");
  EXPECT_EQ(listing.status, 200);
  EXPECT_EQ(listing.field("content-type"), "application/json");
  EXPECT_THAT(listing.body, HasSubstr("\"/walk/reel.json\""));
  const Answer health = get("/healthz");
  EXPECT_EQ(health.status, 200);
  EXPECT_EQ(health.body, "ok\n");
  for (const char* target : {"/walk", "/walk/"}) {
    const Answer redirect = get(target);
    EXPECT_EQ(redirect.status, 308);
    EXPECT_EQ(redirect.field("location"), "/walk/reel.json");
  }
}

TEST_F(HttpServerTest, serves_ranges_of_files_and_of_texts) {
  start();
  RawHttpClient client(port());
  const Answer part = client.get("/walk/0.full.prs", "Range: bytes=600000-699999\r\n");
  EXPECT_EQ(part.status, 206);
  EXPECT_TRUE(part.body == full_.substr(600'000, 100'000));
  EXPECT_EQ(part.field("content-range"), "bytes 600000-699999/700001");
  EXPECT_EQ(part.field("content-length"), "100000");
  EXPECT_FALSE(part.field("etag").empty());
  const Answer tail = client.get("/walk/0.base.prs", "Range: bytes=-10\r\n");
  EXPECT_EQ(tail.status, 206);
  EXPECT_EQ(tail.body, base_.substr(990));
  const Answer text = client.get("/healthz", "Range: bytes=1-1\r\n");
  EXPECT_EQ(text.status, 206);
  EXPECT_EQ(text.body, "k");
  const Answer past = client.get("/walk/0.base.prs", "Range: bytes=1000-\r\n");
  EXPECT_EQ(past.status, 416);
  EXPECT_EQ(past.field("content-range"), "bytes */1000");
  EXPECT_EQ(past.body, "the resource has 1000 bytes\n");
  for (const char* ignored : {"Range: bytes=0-1,5-6\r\n", "Range: bytes=x\r\n",
                              "Range: bytes=0-1\r\nRange: bytes=5-6\r\n"}) {
    const Answer whole = client.get("/walk/0.base.prs", ignored);
    EXPECT_EQ(whole.status, 200) << ignored;
    EXPECT_EQ(whole.body, base_);
  }
}

TEST_F(HttpServerTest, answers_conditional_requests) {
  start();
  RawHttpClient client(port());
  const std::string target = "/walk/0.base.prs", part = "Range: bytes=0-9\r\n";
  const auto status = [&](const std::string& fields) { return client.get(target, fields).status; };
  const Answer same = client.get(target, "If-None-Match: \"x\", W/" + base_tag_ + "\r\n");
  EXPECT_EQ(same.status, 304);
  EXPECT_EQ(same.field("etag"), base_tag_);
  EXPECT_EQ(same.field("cache-control"), "public, max-age=31536000, immutable");
  EXPECT_EQ(status("If-None-Match: \"x\"\r\nIf-None-Match: " + base_tag_ + "\r\n"), 304);
  EXPECT_EQ(status("If-None-Match: *\r\n" + part), 304);
  EXPECT_EQ(status("If-None-Match: \"other\"\r\n"), 200);
  EXPECT_EQ(status("If-Match: \"other\"\r\n"), 412);
  EXPECT_EQ(status("If-Match: " + base_tag_ + "\r\n"), 200);
  EXPECT_EQ(status("If-Range: " + base_tag_ + "\r\n" + part), 206);
  EXPECT_EQ(status("If-Range: \"other\"\r\n" + part), 200);
  EXPECT_EQ(status("If-Range: W/" + base_tag_ + "\r\n" + part), 200);
  EXPECT_EQ(status("If-Range: Sun, 06 Nov 1994 08:49:37 GMT\r\n" + part), 200);
  EXPECT_EQ(status("If-Range: " + base_tag_ + "\r\nRange: bytes=1000-\r\n"), 416);
}

TEST_F(HttpServerTest, answers_head_like_get_without_the_body) {
  start();
  RawHttpClient client(port());
  for (const char* target : {"/walk/0.full.prs", "/walk/reel.json", "/", "/missing"}) {
    const Answer got = client.get(target), head = client.request("HEAD", target);
    EXPECT_EQ(head.status, got.status) << target;
    auto expected = got.fields, fields = head.fields;
    expected.erase("date");
    fields.erase("date");
    EXPECT_EQ(fields, expected) << target;
  }
  const Answer ranged = client.request("HEAD", "/walk/0.base.prs", "Range: bytes=0-1\r\n");
  EXPECT_EQ(ranged.status, 200) << "ranges apply to GET only";
  EXPECT_EQ(client.get("/healthz").body, "ok\n") << "no byte of a body was sent in between";
}

TEST_F(HttpServerTest, answers_preflights_and_refuses_other_methods) {
  start();
  RawHttpClient client(port());
  for (const char* target : {"/walk/0.base.prs", "/missing", "*"}) {
    const Answer options = client.request("OPTIONS", target,
                                          "Origin: http://example.org\r\n"
                                          "Access-Control-Request-Method: GET\r\n"
                                          "Access-Control-Request-Headers: range\r\n");
    EXPECT_EQ(options.status, 204) << target;
    EXPECT_EQ(options.field("access-control-allow-origin"), "");
    EXPECT_EQ(options.field("access-control-allow-methods"), "");
    EXPECT_EQ(options.field("allow"), "GET, HEAD, OPTIONS");
  }
  for (const char* method : {"POST", "PUT", "DELETE", "PATCH", "TRACE", "BREW"}) {
    const Answer answer = client.request(method, "/walk/0.base.prs");
    EXPECT_EQ(answer.status, 405) << method;
    EXPECT_EQ(answer.field("allow"), "GET, HEAD, OPTIONS");
  }
}

TEST_F(HttpServerTest, lets_pages_read_answers_only_if_their_origin_is_allowed) {
  const auto cors = [&](const std::string& origin, const char* method = "GET") {
    return RawHttpClient(port()).request(method, "/walk/0.base.prs",
                                         origin.empty() ? "" : "Origin: " + origin + "\r\n");
  };
  const auto allow = [&](const std::vector<std::string>& origins) {
    HttpServerOptions options;
    options.service.origins = Origins::parse(origins).value();
    start(options);
  };
  allow({});
  EXPECT_EQ(cors("http://example.org").body, base_) << "the browser keeps it from the page";
  EXPECT_EQ(cors("http://example.org").field("access-control-allow-origin"), "");
  allow({"http://example.org", "https://EXAMPLE.net:8443"});
  for (const char* origin : {"http://example.org", "https://example.net:8443"}) {
    EXPECT_EQ(cors(origin).field("access-control-allow-origin"), origin);
    EXPECT_EQ(cors(origin).field("vary"), "Origin");
    EXPECT_EQ(cors(origin).field("cross-origin-resource-policy"), "cross-origin");
    EXPECT_THAT(cors(origin).field("access-control-expose-headers"), HasSubstr("Content-Range"));
    const Answer preflight = cors(origin, "OPTIONS");
    EXPECT_EQ(preflight.status, 204);
    EXPECT_EQ(preflight.field("access-control-allow-methods"), "GET, HEAD, OPTIONS");
    EXPECT_THAT(preflight.field("access-control-allow-headers"), HasSubstr("Range"));
  }
  for (const char* origin : {"", "null", "https://example.org", "http://example.org.evil",
                             "http://example.org:80", "http://example.org, http://a"}) {
    EXPECT_EQ(cors(origin).field("access-control-allow-origin"), "") << origin;
    EXPECT_EQ(cors(origin).field("vary"), "Origin") << "a cache must tell them apart";
  }
  allow({"*"});
  for (const char* origin : {"", "null", "http://example.org"}) {
    EXPECT_EQ(cors(origin).field("access-control-allow-origin"), "*");
    EXPECT_EQ(cors(origin).field("vary"), "");
  }
}

TEST_F(HttpServerTest, answers_on_loopback_only_for_hosts_that_no_page_can_point_there) {
  start();
  const auto status = [&](const std::string& host, const std::string& target = "/") {
    RawHttpClient client(port());
    client.send("GET " + target + " HTTP/1.1\r\nHost: " + host + "\r\n\r\n");
    return client.read_answer().status;
  };
  for (const char* host :
       {"localhost", "LOCALHOST:80", "127.0.0.1:8090", "127.9.9.9", "[::1]:1", "a.localhost"}) {
    EXPECT_EQ(status(host), 200) << host;
  }
  for (const char* host : {"evil.example", "evil.example:8090", "localhost.evil.example",
                           "10.0.0.1", "127.0.0.1.evil.example", "notlocalhost", "[::2]"}) {
    EXPECT_EQ(status(host), 421) << host;
    EXPECT_EQ(status(host, "/metrics"), 421) << host;
    EXPECT_EQ(status(host, "/healthz"), 200) << "for load balancers";
  }
  HttpServerOptions options;
  options.service.origins = Origins::parse({"https://here.example:8443"}).value();
  start(options);
  EXPECT_EQ(status("here.example"), 200);
  EXPECT_EQ(status("evil.example"), 421);
  EXPECT_FALSE(Origins::parse({"example.org"}));
  EXPECT_FALSE(Origins::parse({"https://example.org/page"}));
  EXPECT_FALSE(Origins::parse({""}));
}

TEST_F(HttpServerTest, refuses_every_request_whose_end_others_may_see_elsewhere) {
  start();
  const std::string smuggled = "GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n";
  for (const char* fields :
       {"Transfer-Encoding: identity\r\n", "Transfer-Encoding: gzip, chunked\r\n",
        "Transfer-Encoding: chunked, identity\r\n", "Transfer-Encoding: xchunked\r\n",
        "Transfer-Encoding: chunked\r\nTransfer-Encoding: chunked\r\n",
        "Transfer-Encoding: chunked\r\nTransfer-Encoding: identity\r\n", "Transfer-Encoding: \r\n",
        "Transfer-Encoding: \"chunked\"\r\n", "Transfer-Encoding: chunked;x=1\r\n",
        "Transfer-Encoding\t: chunked\r\n", "Transfer-Encoding: chunked\r\nContent-Length: 5\r\n",
        "Content-Length: 5\r\nTransfer-Encoding: chunked\r\n",
        "Content-Length: 0\r\nTransfer-Encoding: identity\r\n",
        "Content-Length: 5\r\nContent-Length: 6\r\n", "Content-Length: -1\r\n",
        "Content-Length: 5, 6\r\n", "Content-Length : 5\r\n"}) {
    for (const char* method : {"GET", "POST"}) {
      RawHttpClient client(port());
      client.send(std::string(method) + " / HTTP/1.1\r\nHost: localhost\r\n" + fields + "\r\n" +
                  smuggled);
      EXPECT_EQ(client.read_answer().status, 400) << method << ' ' << fields;
      EXPECT_TRUE(client.ends()) << "what follows must not be answered: " << fields;
    }
  }
  RawHttpClient old(port());
  old.send("GET / HTTP/1.0\r\nTransfer-Encoding: chunked\r\n\r\n");
  EXPECT_EQ(old.read_answer().status, 400);
}

TEST_F(HttpServerTest, refuses_request_bodies_and_closes_the_connection) {
  start();
  const std::string smuggled = "GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n";
  for (const std::string& fields :
       {"Content-Length: " + std::to_string(smuggled.size()) + "\r\n\r\n" + smuggled,
        std::string("Transfer-Encoding: chunked\r\n\r\n0\r\n\r\n"),
        std::string("Expect: 100-continue\r\nContent-Length: 5\r\n\r\n")}) {
    RawHttpClient client(port());
    client.send("GET / HTTP/1.1\r\nHost: localhost\r\n" + fields);
    const Answer answer = client.read_answer();
    EXPECT_EQ(answer.status, 413) << fields;
    EXPECT_EQ(answer.field("connection"), "close");
    EXPECT_TRUE(client.ends()) << fields;
  }
  RawHttpClient post(port());
  EXPECT_EQ(post.request("POST", "/", "Content-Length: 3\r\n").status, 405);
  EXPECT_TRUE(post.ends());
  EXPECT_EQ(get("/healthz", "Content-Length: 0\r\n").status, 200);
}

TEST_F(HttpServerTest, serves_nothing_outside_its_packages) {
  start();
  write_file(temporary_.path() / "secret", "secret");
  write_file(reel_ / "notes", "secret");
  RawHttpClient client(port());
  for (const char* target : {"/walk/../secret",
                             "/../secret",
                             "/../../../../../../etc/passwd",
                             "/..",
                             "/walk/..",
                             "/walk/%2e%2e/secret",
                             "/%2e%2e/secret",
                             "/walk/.%2E/secret",
                             "/walk/..%2fsecret",
                             "/walk%2f..%2fsecret",
                             "/walk/%252e%252e/secret",
                             "/walk/..%252fsecret",
                             "/walk/..\\secret",
                             "/walk/%5c..%5csecret",
                             "/walk/%c0%ae%c0%ae/secret",
                             "http://test/walk/../secret",
                             "http://test/%2e%2e/secret",
                             "/walk/notes",
                             "//etc/passwd",
                             "/walk//0.base.prs",
                             "/walk/0.base.prs%00",
                             "/walk/0.base.prs/",
                             "/etc/passwd",
                             "file:///etc/passwd",
                             "/walk/0.base.prs%20"}) {
    const Answer answer = client.get(target);
    EXPECT_TRUE(answer.status == 400 || answer.status == 404) << target << ": " << answer.status;
    EXPECT_THAT(answer.body, testing::Not(HasSubstr("secret"))) << target;
    EXPECT_THAT(answer.body, testing::Not(HasSubstr("root:"))) << target;
    EXPECT_EQ(answer.body.find('\n'), answer.body.size() - 1) << "one line: " << answer.body;
  }
  EXPECT_EQ(client.get("http://anywhere:1234/walk/0.base.prs").body, base_);
  EXPECT_EQ(client.get("/%77alk/0%2ebase.prs").body, base_);
}

TEST_F(HttpServerTest, keeps_connections_alive_and_answers_pipelined_requests_in_order) {
  start();
  RawHttpClient client(port());
  std::string requests;
  for (int i = 0; i < 20; ++i) {
    requests +=
        "GET /walk/0.base.prs HTTP/1.1\r\nHost: localhost\r\nRange: bytes=" + std::to_string(i) +
        "-" + std::to_string(i) + "\r\n\r\n" +
        "GET /walk/0.full.prs HTTP/1.1\r\nHost: localhost\r\n\r\n";
  }
  std::thread sender([&] { EXPECT_TRUE(client.send(requests)); });
  for (int i = 0; i < 20; ++i) {
    const Answer small = client.read_answer();
    ASSERT_EQ(small.status, 206) << i;
    EXPECT_EQ(small.body, base_.substr(static_cast<std::size_t>(i), 1));
    EXPECT_EQ(small.field("connection"), "keep-alive");
    EXPECT_TRUE(client.read_answer().body == full_) << i;
  }
  sender.join();
  EXPECT_EQ(client.get("/healthz", "Connection: close\r\n").field("connection"), "close");
  EXPECT_TRUE(client.ends());
}

TEST_F(HttpServerTest, serves_http_1_0_clients) {
  start();
  RawHttpClient old(port());
  old.send("GET /healthz HTTP/1.0\r\n\r\n");
  EXPECT_EQ(old.read_answer().body, "ok\n");
  EXPECT_TRUE(old.ends());
  RawHttpClient kept(port());
  kept.send("GET /healthz HTTP/1.0\r\nConnection: keep-alive\r\n\r\n");
  EXPECT_EQ(kept.read_answer().field("connection"), "keep-alive");
  EXPECT_EQ(kept.get("/healthz").status, 200);
}

TEST_F(HttpServerTest, accepts_requests_that_arrive_byte_by_byte) {
  start();
  RawHttpClient client(port());
  const std::string request =
      "GET /walk/0.base.prs HTTP/1.1\r\nHost: localhost\r\nRange: bytes=5-6\r\n\r\n";
  for (int round = 0; round < 3; ++round) {
    for (const char c : request) {
      ASSERT_TRUE(client.send(std::string_view(&c, 1)));
      // Bytes that arrive together are read together. A client cannot see when a byte was read.
      std::this_thread::sleep_for(100us);
    }
    const Answer answer = client.read_answer();
    EXPECT_EQ(answer.status, 206);
    EXPECT_EQ(answer.body, base_.substr(5, 2));
  }
}

TEST_F(HttpServerTest, refuses_malformed_requests_in_one_line_and_closes_the_connection) {
  start();
  std::string noise(5000, '\0');
  for (std::size_t i = 0; i < noise.size(); ++i) noise[i] = static_cast<char>(i * 2654435761u >> 9);
  struct Case {
    std::string bytes;
    int status;
  };
  const std::string long_line(9000, 'a');
  const std::vector<Case> cases = {
      {"GET / HTTP/1.1\r\n\r\n", 400},
      {"GET / HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n", 400},
      {"GET / HTTP/2.0\r\nHost: a\r\n\r\n", 505},
      {"GET  / HTTP/1.1\r\nHost: a\r\n\r\n", 400},
      {"GET /a b HTTP/1.1\r\nHost: a\r\n\r\n", 505},
      {"GET / HTTP/1.1\r\nHost : a\r\n\r\n", 400},
      {"GET / HTTP/1.1\r\nHost: a\r\nNo colon\r\n\r\n", 400},
      {"GET / HTTP/1.1\r\nHost: a\r\nContent-Length: x\r\n\r\n", 400},
      {std::string("GET /\0 HTTP/1.1\r\nHost: a\r\n\r\n", 29), 400},
      {"G\x01T / HTTP/1.1\r\nHost: a\r\n\r\n", 400},
      {"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", 505},
      {"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03\r\n\r\n", 400},
      {noise + "\r\n\r\n", 400},
      {"GET /" + long_line + " HTTP/1.1\r\nHost: a\r\n\r\n", 431},
      {"GET / HTTP/1.1\r\nHost: a\r\nX: " + long_line + "\r\n\r\n", 431},
      {std::string(20'000, 'a'), 431},
  };
  for (const Case& c : cases) {
    RawHttpClient client(port());
    client.send(c.bytes);
    const Answer answer = client.read_answer();
    EXPECT_EQ(answer.status, c.status) << testing::PrintToString(c.bytes.substr(0, 60));
    EXPECT_EQ(answer.body.find('\n'), answer.body.size() - 1) << answer.body;
    if (answer.field("connection") == "close") {
      client.end_sending();
      EXPECT_TRUE(client.ends()) << testing::PrintToString(c.bytes.substr(0, 60));
    }
  }
  EXPECT_EQ(get("/healthz").status, 200);
}

TEST_F(HttpServerTest, accepts_heads_up_to_8_kib) {
  start();
  const std::string start_line = "GET /healthz HTTP/1.1\r\nHost: localhost\r\nX: ";
  const std::string fits(8192 - start_line.size() - 4, 'a');
  RawHttpClient client(port());
  client.send(start_line + fits + "\r\n\r\n");
  EXPECT_EQ(client.read_answer().status, 200);
  client.send(start_line + fits + std::string(100, 'a') + "\r\n\r\n");
  EXPECT_EQ(client.read_answer().status, 431);
}

TEST_F(HttpServerTest, protects_resources_by_token_and_keeps_them_out_of_shared_caches) {
  HttpServerOptions options;
  options.service.view_token = "geheim";
  start(options);
  RawHttpClient client(port());
  for (const char* target : {"/", "/walk/reel.json", "/walk/0.base.prs", "/missing", "/metrics"}) {
    for (const char* wrong : {"", "Authorization: Bearer geheim1\r\n",
                              "Authorization: Bearer gehei\r\n", "Authorization: geheim\r\n",
                              "Authorization: Basic geheim\r\n", "Authorization: Bearer\r\n"}) {
      const Answer answer = client.get(target, wrong);
      EXPECT_EQ(answer.status, 401) << target << " " << wrong;
      EXPECT_THAT(answer.field("www-authenticate"), StartsWith("Bearer"));
    }
  }
  EXPECT_EQ(client.get("/healthz").status, 200);
  EXPECT_EQ(client.request("OPTIONS", "/walk/0.base.prs").status, 204) << "preflights have none";
  const Answer given = client.get("/walk/0.base.prs", "authorization: bearer  geheim \r\n");
  EXPECT_EQ(given.status, 200);
  EXPECT_EQ(given.field("cache-control"), "private, max-age=31536000, immutable");
}

TEST_F(HttpServerTest, exports_its_counters_to_prometheus) {
  start();
  RawHttpClient client(port());
  std::size_t body_bytes = 0;
  for (const char* target : {"/walk/0.base.prs", "/walk/0.base.prs", "/missing"})
    body_bytes += client.get(target).body.size();
  EXPECT_GT(body_bytes, 2000u);
  const Answer answer = client.get("/metrics");
  EXPECT_EQ(answer.status, 200);
  EXPECT_EQ(answer.field("content-type"), "text/plain; version=0.0.4; charset=utf-8");
  EXPECT_EQ(answer.field("cache-control"), "no-store");
  for (const std::string& line :
       {std::string("pointreel_http_responses_total{status=\"200\"} 2\n"),
        std::string("pointreel_http_responses_total{status=\"404\"} 1\n"),
        std::string("# TYPE pointreel_http_responses_total counter\n"),
        fmt::format("pointreel_http_body_bytes_total {}\n", body_bytes),
        std::string("pointreel_connections 1\n"), std::string("process_resident_memory_bytes ")}) {
    EXPECT_THAT(answer.body, HasSubstr(line));
  }
  EXPECT_EQ(client.request("HEAD", "/metrics").body, "");
}

}  // namespace
}  // namespace pointreel::http_server_test
