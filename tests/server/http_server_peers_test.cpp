// Clients that are many, slow, silent or gone.

#include <atomic>
#include <filesystem>
#include <memory>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/server/http_server_test.h"

namespace pointreel::http_server_peers_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::StartsWith;
using Answer = RawHttpClient::Answer;
using Clock = std::chrono::steady_clock;

TEST_F(HttpServerTest, refuses_connections_beyond_its_limit_and_recovers) {
  HttpServerOptions options;
  options.max_connections = 8;
  start(options);
  std::vector<std::unique_ptr<RawHttpClient>> clients;
  for (int i = 0; i < 8; ++i) {
    clients.push_back(std::make_unique<RawHttpClient>(port()));
    // Each client is in the middle of a request, so that none is idle.
    ASSERT_TRUE(clients.back()->send("GET /healthz HTTP/1.1\r\n"));
  }
  ASSERT_TRUE(wait_until([&] { return server_->connection_count() == 8; }));
  for (int i = 0; i < 200; ++i) {
    RawHttpClient refused(port());
    const Answer answer = refused.get("/healthz");
    ASSERT_EQ(answer.status, 503) << i;
    EXPECT_EQ(answer.field("retry-after"), "1");
    EXPECT_TRUE(refused.ends());
  }
  for (const auto& client : clients) {
    client->send("Host: localhost\r\n\r\n");
    EXPECT_EQ(client->read_answer().body, "ok\n");
  }
  EXPECT_EQ(server_->connection_count(), 8u);
  clients.pop_back();
  EXPECT_TRUE(wait_until([&] { return get("/healthz").status == 200; }));
}

TEST_F(HttpServerTest, evicts_the_longest_idle_connection_when_it_is_full) {
  HttpServerOptions options;
  options.max_connections = 3;
  options.threads = 1;  // a single thread handles events in the order of arrival
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
  busy.send("Host: localhost\r\n\r\n");
  EXPECT_EQ(busy.read_answer().status, 200);
  EXPECT_THAT(newest.get("/metrics").body, HasSubstr("pointreel_connections_evicted_total 1\n"));
}

TEST_F(HttpServerTest, limits_the_connections_and_requests_of_one_address) {
  HttpServerOptions options;
  options.max_connections_per_address = 2;
  options.requests_per_second = 10;
  start(options);
  RawHttpClient first(port()), second(port());
  ASSERT_TRUE(first.send("GET /healthz HTTP/1.1\r\n") && second.send("GET "));
  ASSERT_TRUE(wait_until([&] { return server_->connection_count() == 2; }));
  const Answer refused = get("/healthz");
  EXPECT_EQ(refused.status, 503);
  EXPECT_THAT(refused.body, HasSubstr("from your address"));
  first.send("Host: localhost\r\n\r\n");
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
  EXPECT_TRUE(wait_until([&] { return first.get("/healthz").status == 200; })) << "after a while";
}

TEST_F(HttpServerTest, keeps_answering_while_far_too_many_peers_connect) {
  HttpServerOptions options;
  options.max_connections = 4;
  start(options);
  RawHttpClient kept(port());
  ASSERT_TRUE(kept.send("GET /walk/0.base.prs HTTP/1.1\r\n"));
  ASSERT_TRUE(wait_until([&] { return server_->connection_count() == 1; }));
  {
    std::vector<std::unique_ptr<RawHttpClient>> silent;
    for (int i = 0; i < 200; ++i) silent.push_back(std::make_unique<RawHttpClient>(port()));
    kept.send("Host: localhost\r\n\r\n");
    EXPECT_EQ(kept.read_answer().body, base_);
    EXPECT_LE(server_->connection_count(), 4u);
  }
  EXPECT_TRUE(wait_until([&] { return get("/healthz").status == 200; }));
}

TEST_F(HttpServerTest, never_lets_a_stalled_reader_delay_others) {
  full_ = patterned(kBig);
  write_package(reel_, base_, full_);
  HttpServerOptions options;
  options.threads = 1;
  options.stall_timeout = 10min;
  start(options);
  std::vector<std::unique_ptr<RawHttpClient>> stalled;
  for (int i = 0; i < 4; ++i) {
    stalled.push_back(std::make_unique<RawHttpClient>(port(), 4096));
    ASSERT_TRUE(stalled.back()->send("GET /walk/0.full.prs HTTP/1.1\r\nHost: localhost\r\n\r\n"));
  }
  ASSERT_TRUE(wait_until([&] { return server_->connection_count() == 4; }));
  RawHttpClient prompt(port());
  for (int i = 0; i < 50; ++i) {
    ASSERT_EQ(prompt.get("/walk/0.base.prs").body, base_);
  }
  EXPECT_TRUE(prompt.get("/walk/0.full.prs").body == full_);
  EXPECT_EQ(server_->connection_count(), 5u);
}

TEST_F(HttpServerTest, drops_readers_that_take_nothing) {
  full_ = patterned(kBig);
  write_package(reel_, base_, full_);
  HttpServerOptions options;
  options.stall_timeout = 300ms;
  start(options);
  RawHttpClient stalled(port(), 4096);
  ASSERT_TRUE(stalled.send("GET /walk/0.full.prs HTTP/1.1\r\nHost: localhost\r\n\r\n"));
  ASSERT_TRUE(stalled.has_something());
  EXPECT_TRUE(wait_until([&] { return server_->connection_count() == 0; }));
  const Answer cut = stalled.read_answer();
  EXPECT_EQ(cut.status, 200);
  EXPECT_LT(cut.body.size(), kBig);
}

TEST_F(HttpServerTest, waits_for_a_reader_that_is_slow_but_still_reads) {
  full_ = patterned(kBig);
  write_package(reel_, base_, full_);
  HttpServerOptions options;
  options.header_timeout = options.idle_timeout = 300ms;
  options.stall_timeout = 10min;
  start(options);
  RawHttpClient slow(port(), 4096);
  ASSERT_TRUE(slow.send("GET /walk/0.full.prs HTTP/1.1\r\nHost: localhost\r\n\r\n"));
  // Later connections are closed, the first because it sends no request, the second because it
  // sends no further one. By then the slow reader has outlasted both timeouts.
  RawHttpClient silent(port()), idle(port());
  EXPECT_EQ(idle.get("/healthz").status, 200);
  EXPECT_TRUE(silent.ends());
  EXPECT_TRUE(idle.ends());
  EXPECT_TRUE(slow.read_answer().body == full_);
}

TEST_F(HttpServerTest, drops_peers_that_never_complete_a_request) {
  HttpServerOptions options;
  options.header_timeout = 300ms;
  options.idle_timeout = 10min;
  start(options);
  std::unique_ptr<RawHttpClient> idle;
  ASSERT_TRUE(wait_until([&] {
    idle = std::make_unique<RawHttpClient>(port());
    return idle->get("/healthz").status == 200;
  }));
  RawHttpClient silent(port()), dripping(port());
  EXPECT_TRUE(silent.ends());
  ASSERT_TRUE(dripping.send("GET / HTTP/1.1\r\nDrops: "));
  EXPECT_TRUE(wait_until([&] { return !dripping.send("."); }))
      << "occasional bytes do not extend the time limit of a head";
  EXPECT_TRUE(dripping.ends());
  EXPECT_EQ(idle->get("/healthz").status, 200) << "it was idle for less than its timeout";
}

TEST_F(HttpServerTest, drops_connections_that_stay_idle) {
  HttpServerOptions options;
  options.idle_timeout = 300ms;
  start(options);
  RawHttpClient idle(port());
  EXPECT_EQ(idle.get("/healthz").status, 200);
  EXPECT_TRUE(idle.ends());
  EXPECT_TRUE(wait_until([&] { return server_->connection_count() == 0; }));
}

TEST_F(HttpServerTest, reports_files_that_changed_and_cuts_off_files_that_shrink) {
  full_ = patterned(kBig);
  write_package(reel_, base_, full_);
  start();
  RawHttpClient slow(port(), 4096);
  ASSERT_TRUE(slow.send("GET /walk/0.full.prs HTTP/1.1\r\nHost: localhost\r\n\r\n"));
  // The head has been sent before the rest of the file changes.
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

TEST_F(HttpServerTest, leaks_no_descriptor_over_a_thousand_connections) {
  full_ = patterned(kBig);
  write_package(reel_, base_, full_);
  start();
  ASSERT_EQ(get("/healthz").status, 200);
  ASSERT_TRUE(wait_until([&] { return server_->connection_count() == 0; }));
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
        client.send("GET /walk/0.full.prs HTTP/1.1\r\nHost: localhost\r\n\r\n");
        break;
      case 3:
        EXPECT_EQ(client.get("/walk/0.base.prs").status, 200);
        break;
    }
  }
  EXPECT_TRUE(wait_until([&] { return server_->connection_count() == 0; }));
  EXPECT_TRUE(wait_until([&] { return open_descriptors() == before; }))
      << before << " before, " << open_descriptors() << " after";
}

TEST_F(HttpServerTest, serves_many_clients_at_once) {
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

TEST_F(HttpServerTest, stops_at_once_and_closes_open_connections) {
  full_ = patterned(kBig);
  write_package(reel_, base_, full_);
  const std::size_t before = open_descriptors();
  HttpServerOptions options;
  options.header_timeout = options.idle_timeout = options.stall_timeout = 10min;
  start(options);
  RawHttpClient idle(port()), half(port()), stalled(port(), 4096), silent(port());
  EXPECT_EQ(idle.get("/healthz").status, 200);
  half.send("GET /hea");
  stalled.send("GET /walk/0.full.prs HTTP/1.1\r\nHost: localhost\r\n\r\n");
  ASSERT_TRUE(wait_until([&] { return server_->connection_count() == 4; }));
  const auto begin = Clock::now();
  const std::uint16_t old_port = port();
  server_->stop();
  EXPECT_LT(Clock::now() - begin, 5min) << "stopping must wait for none of the clients";
  EXPECT_TRUE(idle.ends());
  EXPECT_TRUE(half.ends());
  EXPECT_TRUE(silent.ends());
  EXPECT_EQ(server_->connection_count(), 0u);
  EXPECT_FALSE(RawHttpClient(old_port).connected());
  server_->stop();
  server_.reset();
  EXPECT_EQ(open_descriptors(), before + 4) << "only the sockets of the four clients are left";
}

TEST_F(HttpServerTest, reports_in_one_line_why_it_cannot_listen) {
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
}  // namespace pointreel::http_server_peers_test
