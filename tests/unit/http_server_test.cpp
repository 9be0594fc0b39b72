// The server in this process, real sockets on 127.0.0.1, and peers that behave well or badly.

#include "server/serve/http_server.h"

#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/serve/entity_tag.h"
#include "tests/unit/raw_http_client.h"
#include "tests/unit/served_package.h"

namespace pointreel {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::StartsWith;
using Answer = RawHttpClient::Answer;
using Clock = std::chrono::steady_clock;

/// Larger than all socket buffers on the way together.
constexpr std::size_t kBig = 16 << 20;

class HttpServerTest : public testing::Test {
 protected:
  HttpServerTest() { write_package(reel_, base_, full_); }

  void start(HttpServerOptions options = {}) {
    options.listen.port = 0;
    options.service.log = Log::Level::kOff;
    if (options.threads == 0) options.threads = 2;
    auto catalog = Catalog::load({reel_});
    ASSERT_TRUE(catalog) << catalog.error().message;
    auto server = HttpServer::start(*std::move(catalog), options);
    ASSERT_TRUE(server) << server.error().message;
    server_ = *std::move(server);
  }
  std::uint16_t port() const { return server_->port(); }
  Answer get(const std::string& target, const std::string& fields = "") {
    return RawHttpClient(port()).get(target, fields);
  }

  /// Waits, within bounds, for what other threads bring about.
  static bool soon(const std::function<bool()>& holds) {
    for (const auto end = Clock::now() + 60s; Clock::now() < end;) {
      if (holds()) return true;
      std::this_thread::sleep_for(5ms);
    }
    return holds();
  }
  static std::size_t open_descriptors() {
    std::size_t count = 0;
    for ([[maybe_unused]] const auto& entry : fs::directory_iterator("/proc/self/fd")) ++count;
    return count;
  }

  TemporaryFolder temporary_;
  fs::path reel_ = temporary_.path() / "walk";
  std::string base_ = patterned(1000), full_ = patterned(700'001);
  std::string base_tag_ = make_etag(checksum_of_text(base_));
  std::unique_ptr<HttpServer> server_;
};

TEST_F(HttpServerTest, gives_files_whole_with_all_that_caches_and_browsers_need) {
  start();
  const Answer answer = get("/walk/0.full.prs");
  EXPECT_EQ(answer.status, 200);
  EXPECT_TRUE(answer.body == full_);
  EXPECT_EQ(answer.field("content-type"), "application/octet-stream");
  EXPECT_EQ(answer.field("content-length"), "700001");
  EXPECT_EQ(answer.field("etag"), make_etag(checksum_of_text(full_)));
  EXPECT_EQ(answer.field("cache-control"), "public, max-age=31536000, immutable");
  EXPECT_EQ(answer.field("accept-ranges"), "bytes");
  EXPECT_EQ(answer.field("access-control-allow-origin"), "*");
  EXPECT_THAT(answer.field("access-control-expose-headers"), HasSubstr("Content-Range"));
  EXPECT_EQ(answer.field("x-content-type-options"), "nosniff");
  EXPECT_EQ(answer.field("server"), "pointreel");
  EXPECT_THAT(answer.field("date"), testing::EndsWith(" GMT"));
}

TEST_F(HttpServerTest, gives_the_manifest_the_listing_and_its_health) {
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

TEST_F(HttpServerTest, gives_ranges_of_files_and_of_texts) {
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

TEST_F(HttpServerTest, answers_conditions) {
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
  EXPECT_EQ(ranged.status, 200) << "ranges are for GET alone";
  EXPECT_EQ(client.get("/healthz").body, "ok\n") << "no byte of a body came in between";
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
    EXPECT_EQ(options.field("access-control-allow-origin"), "*");
    EXPECT_EQ(options.field("access-control-allow-methods"), "GET, HEAD, OPTIONS");
    EXPECT_THAT(options.field("access-control-allow-headers"), HasSubstr("Range"));
    EXPECT_EQ(options.field("allow"), "GET, HEAD, OPTIONS");
  }
  for (const char* method : {"POST", "PUT", "DELETE", "PATCH", "TRACE", "BREW"}) {
    const Answer answer = client.request(method, "/walk/0.base.prs");
    EXPECT_EQ(answer.status, 405) << method;
    EXPECT_EQ(answer.field("allow"), "GET, HEAD, OPTIONS");
  }
}

TEST_F(HttpServerTest, refuses_bodies_and_then_ends_for_what_follows_is_not_a_request) {
  start();
  const std::string smuggled = "GET /healthz HTTP/1.1\r\nHost: test\r\n\r\n";
  for (const std::string& fields :
       {"Content-Length: " + std::to_string(smuggled.size()) + "\r\n\r\n" + smuggled,
        std::string("Transfer-Encoding: chunked\r\n\r\n0\r\n\r\n"),
        std::string("Expect: 100-continue\r\nContent-Length: 5\r\n\r\n")}) {
    RawHttpClient client(port());
    client.send("GET / HTTP/1.1\r\nHost: test\r\n" + fields);
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

TEST_F(HttpServerTest, reaches_nothing_outside_its_packages) {
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

TEST_F(HttpServerTest, keeps_connections_and_answers_pipelined_requests_in_order) {
  start();
  RawHttpClient client(port());
  std::string requests;
  for (int i = 0; i < 20; ++i) {
    requests += "GET /walk/0.base.prs HTTP/1.1\r\nHost: test\r\nRange: bytes=" + std::to_string(i) +
                "-" + std::to_string(i) + "\r\n\r\n" +
                "GET /walk/0.full.prs HTTP/1.1\r\nHost: test\r\n\r\n";
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

TEST_F(HttpServerTest, speaks_with_old_clients) {
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

TEST_F(HttpServerTest, understands_requests_that_come_byte_by_byte) {
  start();
  RawHttpClient client(port());
  const std::string request =
      "GET /walk/0.base.prs HTTP/1.1\r\nHost: test\r\nRange: bytes=5-6\r\n\r\n";
  for (int round = 0; round < 3; ++round) {
    for (const char c : request) {
      ASSERT_TRUE(client.send(std::string_view(&c, 1)));
      std::this_thread::sleep_for(100us);
    }
    const Answer answer = client.read_answer();
    EXPECT_EQ(answer.status, 206);
    EXPECT_EQ(answer.body, base_.substr(5, 2));
  }
}

TEST_F(HttpServerTest, refuses_malformed_requests_with_a_line_and_ends_the_connection) {
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
  const std::string start_line = "GET /healthz HTTP/1.1\r\nHost: test\r\nX: ";
  const std::string fits(8192 - start_line.size() - 4, 'a');
  RawHttpClient client(port());
  client.send(start_line + fits + "\r\n\r\n");
  EXPECT_EQ(client.read_answer().status, 200);
  client.send(start_line + fits + std::string(100, 'a') + "\r\n\r\n");
  EXPECT_EQ(client.read_answer().status, 431);
}

TEST_F(HttpServerTest, tells_one_connection_too_many_and_recovers) {
  HttpServerOptions options;
  options.max_connections = 8;
  start(options);
  std::vector<std::unique_ptr<RawHttpClient>> clients;
  for (int i = 0; i < 8; ++i) {
    clients.push_back(std::make_unique<RawHttpClient>(port()));
    // In the middle of a request, so that none is idle.
    ASSERT_TRUE(clients.back()->send("GET /healthz HTTP/1.1\r\n"));
  }
  ASSERT_TRUE(soon([&] { return server_->connection_count() == 8; }));
  for (int i = 0; i < 200; ++i) {
    RawHttpClient refused(port());
    const Answer answer = refused.get("/healthz");
    ASSERT_EQ(answer.status, 503) << i;
    EXPECT_EQ(answer.field("retry-after"), "1");
    EXPECT_TRUE(refused.ends());
  }
  for (const auto& client : clients) {
    client->send("Host: test\r\n\r\n");
    EXPECT_EQ(client->read_answer().body, "ok\n");
  }
  EXPECT_EQ(server_->connection_count(), 8u);
  clients.pop_back();
  EXPECT_TRUE(soon([&] { return get("/healthz").status == 200; }));
}

TEST_F(HttpServerTest, lets_the_connection_go_that_has_been_idle_for_longest_when_it_is_full) {
  HttpServerOptions options;
  options.max_connections = 3;
  options.threads = 1;  // it takes what comes in the order in which it comes
  start(options);
  RawHttpClient oldest(port()), busy(port()), newest(port());
  ASSERT_EQ(busy.get("/healthz").status, 200);
  ASSERT_EQ(oldest.get("/healthz").status, 200);
  ASSERT_EQ(newest.get("/healthz").status, 200);
  ASSERT_TRUE(busy.send("GET /healthz HTTP/1.1\r\n"));
  ASSERT_EQ(newest.get("/healthz").status, 200);
  EXPECT_EQ(get("/healthz").status, 200);
  EXPECT_TRUE(oldest.ends());
  EXPECT_EQ(newest.get("/healthz").status, 200);
  busy.send("Host: test\r\n\r\n");
  EXPECT_EQ(busy.read_answer().status, 200);
  EXPECT_THAT(newest.get("/metrics").body, HasSubstr("pointreel_connections_evicted_total 1\n"));
}

TEST_F(HttpServerTest, bounds_what_one_address_may_have) {
  HttpServerOptions options;
  options.max_connections_per_address = 2;
  options.requests_per_second = 1;
  start(options);
  RawHttpClient first(port()), second(port());
  ASSERT_TRUE(first.send("GET /healthz HTTP/1.1\r\n") && second.send("GET "));
  ASSERT_TRUE(soon([&] { return server_->connection_count() == 2; }));
  const Answer refused = get("/healthz");
  EXPECT_EQ(refused.status, 503);
  EXPECT_THAT(refused.body, HasSubstr("from your address"));
  first.send("Host: test\r\n\r\n");
  ASSERT_EQ(first.read_answer().status, 200);
  int limited = 0;
  for (int i = 0; i < 200; ++i) {
    const Answer answer = first.get("/walk/0.base.prs", "Range: bytes=0-0\r\n");
    if (answer.status == 429) {
      ++limited;
      EXPECT_EQ(answer.field("retry-after"), "1");
    } else {
      EXPECT_EQ(answer.status, 206);
    }
  }
  EXPECT_GT(limited, 0);
  EXPECT_TRUE(soon([&] { return first.get("/healthz").status == 200; })) << "after a while";
}

TEST_F(HttpServerTest, keeps_what_tokens_guard_from_others_and_from_shared_caches) {
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

TEST_F(HttpServerTest, tells_prometheus_what_it_did) {
  start();
  RawHttpClient client(port());
  client.get("/walk/0.base.prs");
  client.get("/walk/0.base.prs");
  client.get("/missing");
  const Answer answer = client.get("/metrics");
  EXPECT_EQ(answer.status, 200);
  EXPECT_EQ(answer.field("content-type"), "text/plain; version=0.0.4; charset=utf-8");
  EXPECT_EQ(answer.field("cache-control"), "no-store");
  for (const char* line :
       {"pointreel_http_responses_total{status=\"200\"} 2\n",
        "pointreel_http_responses_total{status=\"404\"} 1\n",
        "# TYPE pointreel_http_responses_total counter\n", "pointreel_http_body_bytes_total 2044\n",
        "pointreel_connections 1\n", "process_resident_memory_bytes "}) {
    EXPECT_THAT(answer.body, HasSubstr(line));
  }
  EXPECT_EQ(client.request("HEAD", "/metrics").body, "");
}

TEST_F(HttpServerTest, keeps_answering_when_far_too_many_connect_at_once) {
  HttpServerOptions options;
  options.max_connections = 4;
  start(options);
  RawHttpClient kept(port());
  ASSERT_TRUE(kept.send("GET /walk/0.base.prs HTTP/1.1\r\n"));
  ASSERT_TRUE(soon([&] { return server_->connection_count() == 1; }));
  {
    std::vector<std::unique_ptr<RawHttpClient>> silent;
    for (int i = 0; i < 200; ++i) silent.push_back(std::make_unique<RawHttpClient>(port()));
    kept.send("Host: test\r\n\r\n");
    EXPECT_EQ(kept.read_answer().body, base_);
    EXPECT_LE(server_->connection_count(), 4u);
  }
  EXPECT_TRUE(soon([&] { return get("/healthz").status == 200; }));
}

TEST_F(HttpServerTest, lets_a_reader_that_stalls_block_nobody) {
  full_ = patterned(kBig);
  write_package(reel_, base_, full_);
  HttpServerOptions options;
  options.threads = 1;
  options.stall_timeout = 10min;
  start(options);
  std::vector<std::unique_ptr<RawHttpClient>> stalled;
  for (int i = 0; i < 4; ++i) {
    stalled.push_back(std::make_unique<RawHttpClient>(port(), 4096));
    ASSERT_TRUE(stalled.back()->send("GET /walk/0.full.prs HTTP/1.1\r\nHost: test\r\n\r\n"));
  }
  ASSERT_TRUE(soon([&] { return server_->connection_count() == 4; }));
  RawHttpClient prompt(port());
  for (int i = 0; i < 50; ++i) {
    ASSERT_EQ(prompt.get("/walk/0.base.prs").body, base_);
  }
  EXPECT_TRUE(prompt.get("/walk/0.full.prs").body == full_);
  EXPECT_EQ(server_->connection_count(), 5u);
}

TEST_F(HttpServerTest, gives_up_readers_that_take_nothing) {
  full_ = patterned(kBig);
  write_package(reel_, base_, full_);
  HttpServerOptions options;
  options.stall_timeout = 300ms;
  start(options);
  RawHttpClient stalled(port(), 4096);
  ASSERT_TRUE(stalled.send("GET /walk/0.full.prs HTTP/1.1\r\nHost: test\r\n\r\n"));
  ASSERT_TRUE(stalled.has_something());
  EXPECT_TRUE(soon([&] { return server_->connection_count() == 0; }));
  const Answer cut = stalled.read_answer();
  EXPECT_EQ(cut.status, 200);
  EXPECT_LT(cut.body.size(), kBig);
}

TEST_F(HttpServerTest, waits_for_a_reader_that_is_slow_but_moves) {
  full_ = patterned(kBig);
  write_package(reel_, base_, full_);
  HttpServerOptions options;
  options.header_timeout = options.idle_timeout = 300ms;
  options.stall_timeout = 10min;
  start(options);
  RawHttpClient slow(port(), 4096);
  ASSERT_TRUE(slow.send("GET /walk/0.full.prs HTTP/1.1\r\nHost: test\r\n\r\n"));
  std::this_thread::sleep_for(1s);  // longer than every timeout but the one that counts
  EXPECT_TRUE(slow.read_answer().body == full_);
}

TEST_F(HttpServerTest, gives_up_those_that_do_not_ask) {
  HttpServerOptions options;
  options.header_timeout = 300ms;
  options.idle_timeout = 10min;
  start(options);
  std::unique_ptr<RawHttpClient> idle;
  ASSERT_TRUE(soon([&] {
    idle = std::make_unique<RawHttpClient>(port());
    return idle->get("/healthz").status == 200;
  }));
  RawHttpClient silent(port()), dripping(port());
  EXPECT_TRUE(silent.ends());
  ASSERT_TRUE(dripping.send("GET / HTTP/1.1\r\nDrops: "));
  EXPECT_TRUE(soon([&] { return !dripping.send("."); }))
      << "a byte now and then does not extend the time for a head";
  EXPECT_TRUE(dripping.ends());
  EXPECT_EQ(idle->get("/healthz").status, 200) << "idle for less than its timeout";
}

TEST_F(HttpServerTest, gives_up_those_that_ask_for_nothing_more) {
  HttpServerOptions options;
  options.idle_timeout = 300ms;
  start(options);
  RawHttpClient idle(port());
  EXPECT_EQ(idle.get("/healthz").status, 200);
  EXPECT_TRUE(idle.ends());
  EXPECT_TRUE(soon([&] { return server_->connection_count() == 0; }));
}

TEST_F(HttpServerTest, says_so_when_a_file_changed_and_ends_early_when_it_shrinks) {
  full_ = patterned(kBig);
  write_package(reel_, base_, full_);
  start();
  RawHttpClient slow(port(), 4096);
  ASSERT_TRUE(slow.send("GET /walk/0.full.prs HTTP/1.1\r\nHost: test\r\n\r\n"));
  // The head has left before the file changes under the rest.
  ASSERT_TRUE(slow.has_something());
  RawHttpClient second(port());
  ASSERT_EQ(second.get("/walk/0.base.prs").body, base_);
  fs::resize_file(reel_ / "0.full.prs", 100);
  fs::remove(reel_ / "0.base.prs");
  const Answer cut = slow.read_answer();
  EXPECT_EQ(cut.status, 200);
  EXPECT_LT(cut.body.size(), kBig);
  EXPECT_TRUE(slow.ends());
  for (const char* target : {"/walk/0.full.prs", "/walk/0.base.prs"}) {
    const Answer answer = second.get(target);
    EXPECT_EQ(answer.status, 500) << target;
    EXPECT_THAT(answer.body, StartsWith("the package changed on disk"));
  }
  EXPECT_EQ(second.get("/walk/reel.json").status, 200);
}

TEST_F(HttpServerTest, leaves_no_descriptor_behind_after_a_thousand_connections) {
  full_ = patterned(kBig);
  write_package(reel_, base_, full_);
  start();
  ASSERT_EQ(get("/healthz").status, 200);
  ASSERT_TRUE(soon([&] { return server_->connection_count() == 0; }));
  const std::size_t before = open_descriptors();
  for (int i = 0; i < 1000; ++i) {
    RawHttpClient client(port());
    ASSERT_TRUE(client.connected()) << i;
    switch (i % 4) {
      case 0:
        break;
      case 1:
        client.send("GET /wal");
        break;
      case 2:
        client.send("GET /walk/0.full.prs HTTP/1.1\r\nHost: test\r\n\r\n");
        break;
      case 3:
        EXPECT_EQ(client.get("/walk/0.base.prs").status, 200);
        break;
    }
  }
  EXPECT_TRUE(soon([&] { return server_->connection_count() == 0; }));
  EXPECT_TRUE(soon([&] { return open_descriptors() == before; }))
      << before << " before, " << open_descriptors() << " after";
}

TEST_F(HttpServerTest, serves_many_at_once) {
  start();
  std::atomic<int> right{0};
  std::vector<std::thread> clients;
  for (int t = 0; t < 8; ++t) {
    clients.emplace_back([&, t] {
      RawHttpClient client(port());
      for (int i = 0; i < 50; ++i) {
        const auto first = static_cast<std::size_t>(t * 50'000 + i * 997);
        const Answer answer =
            client.get("/walk/0.full.prs", "Range: bytes=" + std::to_string(first) + "-\r\n");
        if (answer.body == full_.substr(first)) ++right;
      }
    });
  }
  for (std::thread& client : clients) client.join();
  EXPECT_EQ(right, 8 * 50);
}

TEST_F(HttpServerTest, stops_with_connections_open_and_closes_them) {
  full_ = patterned(kBig);
  write_package(reel_, base_, full_);
  const std::size_t before = open_descriptors();
  HttpServerOptions options;
  options.header_timeout = options.idle_timeout = options.stall_timeout = 10min;
  start(options);
  RawHttpClient idle(port()), half(port()), stalled(port(), 4096), silent(port());
  EXPECT_EQ(idle.get("/healthz").status, 200);
  half.send("GET /hea");
  stalled.send("GET /walk/0.full.prs HTTP/1.1\r\nHost: test\r\n\r\n");
  ASSERT_TRUE(soon([&] { return server_->connection_count() == 4; }));
  const auto begin = Clock::now();
  const std::uint16_t old_port = port();
  server_->stop();
  EXPECT_LT(Clock::now() - begin, 5min) << "it waits for none of them";
  EXPECT_TRUE(idle.ends());
  EXPECT_TRUE(half.ends());
  EXPECT_TRUE(silent.ends());
  EXPECT_EQ(server_->connection_count(), 0u);
  EXPECT_FALSE(RawHttpClient(old_port).connected());
  server_->stop();
  server_.reset();
  EXPECT_EQ(open_descriptors(), before + 4) << "the four clients' own";
}

TEST_F(HttpServerTest, says_in_one_line_why_it_cannot_listen) {
  start();
  HttpServerOptions options;
  options.listen.port = port();
  const auto second = HttpServer::start(*Catalog::load({reel_}), options);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().message, "cannot listen on 127.0.0.1:" + std::to_string(port()) +
                                        ": Address already in use; choose another with --listen");
  options.listen = {"192.0.2.1", 0};
  const auto foreign = HttpServer::start(*Catalog::load({reel_}), options);
  ASSERT_FALSE(foreign);
  EXPECT_THAT(foreign.error().message, HasSubstr("192.0.2.1:0: Cannot assign requested address"));
}

}  // namespace
}  // namespace pointreel
