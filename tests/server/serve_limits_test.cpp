// Who may connect, request and view, and what is logged about it, without a socket.

#include <array>
#include <chrono>
#include <cstdlib>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "server/serve/message_pace.h"
#include "server/service/access.h"
#include "server/service/connection_table.h"
#include "server/service/log.h"
#include "server/service/metrics.h"
#include "server/service/peer.h"
#include "server/service/peer_quota.h"
#include "server/service/rate_limiter.h"

namespace pointreel::serve_limits_test {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using Refusal = ConnectionTable::Refusal;
using Right = Access::Right;
using Verdict = Access::Verdict;

Peer v4(std::uint8_t a, std::uint8_t d) {
  return peer_of({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff, a, 0, 0, d});
}

/// A connection table and the connections that it closed.
struct Connections {
  ConnectionTable table;
  std::vector<int> closed;
  auto admit(int number, std::uint8_t address) {
    return table.admit(v4(10, address), [this, number] { closed.push_back(number); });
  }
};
const ConnectionTable::Clock::time_point kTime(1h);

TEST(PeerOf, recognises_loopback_and_groups_the_ipv6_addresses_of_one_network) {
  EXPECT_EQ(v4(127, 1).address, "127.0.0.1");
  EXPECT_TRUE(v4(127, 9).loopback);
  EXPECT_FALSE(v4(10, 1).loopback);
  EXPECT_NE(v4(10, 1).network, v4(10, 2).network);
  std::array<std::uint8_t, 16> v6{0x20, 1, 0xd, 0xb8, 0, 0, 0, 7};
  v6[15] = 1;
  const Peer one = peer_of(v6);
  v6[15] = 2;
  EXPECT_EQ(one.network, peer_of(v6).network);
  v6[7] = 8;
  EXPECT_NE(one.network, peer_of(v6).network);
  EXPECT_EQ(one.address, "2001:db8:0:7::1");
  EXPECT_FALSE(one.loopback);
  std::array<std::uint8_t, 16> own{};
  own[15] = 1;
  EXPECT_TRUE(peer_of(own).loopback);
}

TEST(ConnectionTable, frees_a_place_when_a_connection_ends) {
  Connections all{{2, 2}, {}};
  auto first = all.admit(1, 1);
  auto second = std::make_unique<decltype(first)>(all.admit(2, 1));
  ASSERT_TRUE(first && *second);
  EXPECT_EQ(all.admit(3, 2).error(), Refusal::kFull);
  EXPECT_EQ(all.table.count(), 2u);
  second.reset();
  EXPECT_EQ(all.table.count(), 1u);
  EXPECT_TRUE(all.admit(3, 2));
  EXPECT_THAT(all.closed, testing::IsEmpty());
}

TEST(ConnectionTable, evicts_the_longest_idle_connection_and_never_a_busy_one) {
  Connections all{{3, 9}, {}};
  auto one = all.admit(1, 1), two = all.admit(2, 2), three = all.admit(3, 3);
  one->idle(kTime + 3s);
  two->idle(kTime + 1s);
  three->idle(kTime);
  three->busy();
  auto four = all.admit(4, 4);
  ASSERT_TRUE(four);
  EXPECT_THAT(all.closed, testing::ElementsAre(2));
  EXPECT_EQ(all.table.count(), 3u);
  auto five = all.admit(5, 5);
  ASSERT_TRUE(five);
  EXPECT_THAT(all.closed, testing::ElementsAre(2, 1));
  EXPECT_EQ(all.admit(6, 6).error(), Refusal::kFull) << "all other connections are busy";
  EXPECT_EQ(all.table.evicted(), 2u);
}

TEST(ConnectionTable, evicts_within_an_address_that_is_at_its_limit) {
  Connections all{{9, 2}, {}};
  auto other = all.admit(1, 1), one = all.admit(2, 7), two = all.admit(3, 7);
  other->idle(kTime);
  EXPECT_EQ(all.admit(4, 7).error(), Refusal::kAddress);
  EXPECT_THAT(all.closed, testing::IsEmpty());
  two->idle(kTime + 1s);
  EXPECT_TRUE(all.admit(4, 7));
  EXPECT_THAT(all.closed, testing::ElementsAre(3));
}

TEST(PeerQuota, limits_what_peers_hold_together_and_each_address_on_its_own) {
  PeerQuota quota(100, 60);
  PeerQuota::Share one(quota, v4(10, 1)), again(quota, v4(10, 1)), other(quota, v4(10, 2));
  EXPECT_TRUE(one.grow(40));
  EXPECT_FALSE(again.grow(21)) << "of one address";
  EXPECT_TRUE(again.grow(20));
  EXPECT_FALSE(other.grow(41)) << "of all";
  EXPECT_TRUE(other.grow(40));
  EXPECT_EQ(quota.held(), 100u);
  one.clear();
  EXPECT_EQ(quota.held(), 60u);
  EXPECT_TRUE(again.grow(40));
  EXPECT_FALSE(again.grow(~std::size_t{0}));
  {
    const PeerQuota::Share moved(std::move(again));
    EXPECT_EQ(quota.held(), 100u);
  }
  EXPECT_EQ(quota.held(), 40u);
  other = PeerQuota::Share();
  EXPECT_EQ(quota.held(), 0u);
}

TEST(MessagePace, is_due_by_the_hello_and_then_by_the_rate_of_the_message_under_way) {
  constexpr auto kNever = MessagePace::Clock::time_point::max();
  MessagePace pace(1000, kTime + 10s);
  EXPECT_EQ(pace.due(), kTime + 10s);
  pace.came(1000, kTime);
  EXPECT_EQ(pace.due(), kTime + Pace::kPatience + 1s);
  pace.came(9000, kTime + 5s);
  EXPECT_EQ(pace.due(), kTime + 10s) << "the hello is due before";
  pace.ended();
  EXPECT_TRUE(pace.awaits_hello());
  pace.greeted();
  EXPECT_EQ(pace.due(), kNever) << "nothing is under way";
  pace.came(1, kTime + 60s);
  EXPECT_EQ(pace.due(), kTime + 60s + Pace::kPatience + 1ms);
  pace.came(1999, kTime + 61s);
  EXPECT_EQ(pace.due(), kTime + 60s + Pace::kPatience + 2s);
  pace.ended();
  pace.came(0, kTime + 90s);
  pace.came(0, kTime + 94s);
  EXPECT_EQ(pace.due(), kTime + 90s + Pace::kPatience) << "empty pieces gain no time";
  MessagePace any(0, kTime);
  any.greeted();
  any.came(1, kTime);
  EXPECT_EQ(any.due(), kNever);
}

TEST(RateLimiter, permits_a_burst_of_one_second_and_then_the_given_rate) {
  RateLimiter limiter(10);
  const auto network = v4(10, 1).network, other = v4(10, 2).network;
  const auto let_through = [&](auto at) {
    int count = 0;
    for (int i = 0; i < 100; ++i) count += limiter.allow(network, at) ? 1 : 0;
    return count;
  };
  EXPECT_EQ(let_through(kTime), 10);
  EXPECT_TRUE(limiter.allow(other, kTime));
  EXPECT_EQ(let_through(kTime + 300ms), 3);
  EXPECT_EQ(let_through(kTime + 10s), 10);
  EXPECT_EQ(RateLimiter(0).size(), 0u);
  EXPECT_TRUE(RateLimiter(0).allow(network, kTime));
  RateLimiter rare(0.1);
  EXPECT_TRUE(rare.allow(network, kTime));
  EXPECT_FALSE(rare.allow(network, kTime + 9s));
  EXPECT_TRUE(rare.allow(network, kTime + 11s));
}

TEST(RateLimiter, remembers_a_bounded_number_of_addresses) {
  RateLimiter limiter(10);
  RateLimiter::Network network{};
  for (std::uint32_t i = 0; i < 2 * RateLimiter::kMost; ++i) {
    network[0] = static_cast<std::uint8_t>(i);
    network[1] = static_cast<std::uint8_t>(i >> 8);
    network[2] = static_cast<std::uint8_t>(i >> 16);
    EXPECT_TRUE(limiter.allow(network, kTime));
  }
  EXPECT_EQ(limiter.size(), RateLimiter::kMost);
  network[3] = 1;
  EXPECT_TRUE(limiter.allow(network, kTime + 1s));
  EXPECT_EQ(limiter.size(), 1u) << "addresses without recent requests are forgotten";
}

TEST(Access, separates_the_rights_to_view_and_to_publish) {
  const Access open("", "");
  EXPECT_EQ(open.check(Right::kView, "", false), Verdict::kGranted);
  EXPECT_EQ(open.check(Right::kPublish, "", true), Verdict::kGranted);
  EXPECT_EQ(open.check(Right::kPublish, "", false), Verdict::kOnlyNearby);
  EXPECT_EQ(open.check(Right::kPublish, "Bearer x", false), Verdict::kOnlyNearby);
  EXPECT_TRUE(open.viewing_is_public());
  const Access both("look", "show");
  EXPECT_FALSE(both.viewing_is_public());
  EXPECT_EQ(both.check(Right::kView, "Bearer look", false), Verdict::kGranted);
  EXPECT_EQ(both.check(Right::kView, "Bearer show", true), Verdict::kNoToken);
  EXPECT_EQ(both.check(Right::kPublish, "Bearer show", false), Verdict::kGranted);
  EXPECT_EQ(both.check(Right::kPublish, "Bearer look", true), Verdict::kNoToken);
  EXPECT_EQ(both.check(Right::kPublish, "", true), Verdict::kNoToken)
      << "with a token set, this machine needs it too";
}

TEST(Log, writes_one_json_object_a_line_for_any_content) {
  const std::string line = write_log_line(Log::Level::kWarning, "request",
                                          {{"target", std::string_view("/a\"\n\x01\xff{}")},
                                           {"status", std::int64_t{404}},
                                           {"ms", 0.5},
                                           {"whole", true}},
                                          1'769'860'800'123'456);
  EXPECT_EQ(line.find('\n'), std::string::npos);
  const auto parsed = nlohmann::json::parse(line);
  EXPECT_EQ(parsed["time"], "2026-01-31T12:00:00.123Z");
  EXPECT_EQ(parsed["level"], "warning");
  EXPECT_EQ(parsed["event"], "request");
  EXPECT_EQ(parsed["status"], 404);
  EXPECT_EQ(parsed["whole"], true);
  EXPECT_THAT(parsed["target"].get<std::string>(), testing::StartsWith("/a\"\n\x01"));
}

TEST(Log, writes_only_messages_at_or_above_its_level) {
  testing::internal::CaptureStderr();
  {
    Log log(Log::Level::kWarning);
    EXPECT_FALSE(log.writes(Log::Level::kInfo));
    log.write(Log::Level::kInfo, "small");
    log.write(Log::Level::kError, "grave");
  }
  const std::string text = testing::internal::GetCapturedStderr();
  EXPECT_THAT(text, HasSubstr("\"event\":\"grave\""));
  EXPECT_THAT(text, testing::Not(HasSubstr("small")));
  EXPECT_EQ(*parse_log_level("error"), Log::Level::kError);
  EXPECT_THAT(parse_log_level("loud").error().message, HasSubstr("--log loud"));
}

TEST(Metrics, declare_every_name_once_and_have_a_number_in_every_line) {
  Metrics metrics;
  for (const int status : {100, 206, 206, 599, 99, 600}) metrics.count_response(status);
  StreamStatistics stream;
  stream.name = "stage-1";
  stream.viewers = 3;
  stream.newest_capture_us = 1'769'860'800'500'000;
  const std::string page = write_metrics(metrics, {5, 2, {stream, stream}});
  std::istringstream lines(page);
  std::map<std::string, int> types;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("# TYPE ")) ++types[line.substr(7, line.find(' ', 7) - 7)];
    if (line.starts_with('#')) continue;
    const std::string name = line.substr(0, line.find_first_of("{ "));
    EXPECT_EQ(types[name], 1) << line;
    char* end = nullptr;
    const std::string value = line.substr(line.rfind(' ') + 1);
    std::strtod(value.c_str(), &end);
    EXPECT_EQ(*end, '\0') << line;
  }
  EXPECT_THAT(page, HasSubstr("pointreel_http_responses_total{status=\"206\"} 2\n"));
  EXPECT_THAT(page, HasSubstr("pointreel_live_viewers{stream=\"stage-1\"} 3\n"));
  EXPECT_THAT(page, HasSubstr("pointreel_live_newest_capture_seconds{stream=\"stage-1\"} "
                              "1769860800.5\n"));
  EXPECT_THAT(page, HasSubstr("pointreel_connections 5\n"));
}

}  // namespace
}  // namespace pointreel::serve_limits_test
