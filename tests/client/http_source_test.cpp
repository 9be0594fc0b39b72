#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/source/open_source.h"
#include "client/source/whole_files.h"
#include "codec/package/manifest.h"
#include "pointreel/chunks.h"
#include "tests/scripted_http_server.h"
#include "tests/small_package.h"
#include "tests/wait.h"

namespace pointreel::http_source_test {
namespace {

using std::chrono::milliseconds;
using testing::HasSubstr;

/// Serves the small package. `layer` answers the requests for layer files.
ScriptedHttpServer::Handler serving(ScriptedHttpServer::Handler layer) {
  return [layer](int socket, const std::string& head) {
    if (!head.starts_with("GET /reel/reel.json ")) return layer(socket, head);
    answer(socket, "200 OK", "", write_manifest(small_manifest()));
    return true;
  };
}

bool serve_range(int socket, const std::string& head) {
  const RequestedRange range = range_of(head);
  const std::size_t total = head.find("base") != std::string::npos ? 30 : 8;
  answer(socket, "206 Partial Content",
         fmt::format("Content-Range: bytes {}-{}/{}\r\n", range.first, range.last, total),
         text_of(offsets(range.first, range.last - range.first + 1)));
  return true;
}

/// The error of fetching the base of frame 0 when `layer` answers the requests for layer files.
std::string fetch_error(ScriptedHttpServer::Handler layer, int* requests = nullptr,
                        const SourceOptions& options = patient()) {
  ScriptedHttpServer server(serving(std::move(layer)));
  auto source = open_source(server.url() + "/reel", options);
  if (!source) return "not opened: " + source.error().message;
  const auto fetched = (*source)->fetch({0, {0, 1, true, true}});
  if (requests) *requests = server.requests - 1;
  return fetched ? "no error" : fetched.error().message;
}

TEST(HttpSource, fetches_ranges_over_at_most_one_connection_a_layer) {
  ScriptedHttpServer server(serving(serve_range));
  for (const std::string end : {"/reel", "/reel/", "/reel/reel.json"}) {
    server.connections = 0;
    auto source = open_source(server.url() + end, patient());
    ASSERT_TRUE(source) << source.error().message;
    const auto frame = (*source)->fetch({1});
    ASSERT_TRUE(frame) << frame.error().message;
    EXPECT_EQ(frame->layers[0].bytes, offsets(9, 21));
    EXPECT_EQ(frame->layers[1].bytes, offsets(5, 3));
    EXPECT_LE(server.connections, 2);
  }
}

TEST(HttpSource, asks_for_every_file_with_the_query_of_the_address) {
  std::mutex mutex;
  std::vector<std::string> targets;
  ScriptedHttpServer server([&](int socket, const std::string& head) {
    const std::string target = head.substr(4, head.find(" HTTP") - 4);
    {
      const std::lock_guard lock(mutex);
      targets.push_back(target);
    }
    if (target.starts_with("/reel/reel.json")) {
      answer(socket, "200 OK", "", write_manifest(small_manifest()));
      return true;
    }
    return serve_range(socket, head);
  });
  for (const std::string end : {"?key=a/b&x", "/?key=a/b&x#frame", "/reel.json?key=a/b&x"}) {
    auto source = open_source(server.url() + "/reel" + end, patient());
    ASSERT_TRUE(source) << source.error().message;
    const auto frame = (*source)->fetch({1});
    ASSERT_TRUE(frame) << frame.error().message;
    EXPECT_EQ(frame->layers[0].bytes, offsets(9, 21));
  }
  EXPECT_THAT(targets, testing::Each(testing::EndsWith("?key=a/b&x")));
  EXPECT_THAT(targets, testing::Contains("/reel/reel.json?key=a/b&x").Times(3));
  targets.clear();
  EXPECT_TRUE(open_source(server.url() + "/reel#frame", patient()));
  EXPECT_THAT(targets, testing::ElementsAre("/reel/reel.json"));
}

TEST(HttpSource, fetches_only_the_requested_layers_and_attributes) {
  ScriptedHttpServer server(serving(serve_range));
  auto source = open_source(server.url() + "/reel", patient());
  const auto frame = (*source)->fetch({1, {0, 1, false, false}});
  ASSERT_TRUE(frame);
  ASSERT_EQ(frame->layers.size(), 1u);
  EXPECT_EQ(frame->layers[0].bytes, offsets(9, 10));
  EXPECT_EQ(frame->layers[0].sizes, (Chunks<std::uint32_t>{10, 0, 0}));
}

TEST(HttpSource, serves_many_threads_at_once) {
  ScriptedHttpServer server(serving(serve_range));
  auto source = open_source(server.url() + "/reel", patient());
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&] {
      for (int i = 0; i < 20; ++i) {
        const auto frame = (*source)->fetch({1});
        ASSERT_TRUE(frame);
        EXPECT_EQ(frame->layers[0].bytes, offsets(9, 21));
      }
    });
  for (std::thread& thread : threads) thread.join();
}

TEST(HttpSource, accepts_a_whole_file_as_the_range_that_covers_it) {
  Manifest manifest = small_manifest();
  manifest.segments[0].times_us = {0};
  manifest.segments[0].points = {5};
  manifest.segments[0].layers = {{{"0.base.bin", 9, 1}, {{4, 3, 2}}},
                                 {{"0.full.bin", 2, 2}, {{2, 0, 0}}}};
  ScriptedHttpServer server([&](int socket, const std::string& head) {
    const auto has = [&](const char* name) { return head.find(name) != std::string::npos; };
    answer(socket, "200 OK", "",
           has("reel.json") ? write_manifest(manifest) : text_of(offsets(0, has("base") ? 9 : 2)));
    return true;
  });
  auto source = open_source(server.url(), patient());
  ASSERT_TRUE(source) << source.error().message;
  EXPECT_EQ((*source)->fetch({0})->layers[0].bytes, offsets(0, 9));
}

TEST(HttpSource, reports_that_there_is_no_package) {
  ScriptedHttpServer server([](int socket, const std::string&) {
    answer(socket, "404 Not Found", "", "nothing");
    return true;
  });
  const auto source = open_source(server.url() + "/nowhere", patient());
  EXPECT_THAT(source.error().message,
              testing::AllOf(HasSubstr("/nowhere/reel.json"), HasSubstr("404"),
                             HasSubstr("give the folder or address of a package")));
  EXPECT_EQ(server.requests, 1) << "asking again would not help";
}

TEST(HttpSource, reports_that_a_web_page_is_not_a_manifest) {
  ScriptedHttpServer server([](int socket, const std::string&) {
    answer(socket, "200 OK", "Content-Type: text/html\r\n", "<html>Welcome</html>");
    return true;
  });
  const auto source = open_source(server.url(), patient());
  ASSERT_FALSE(source);
  EXPECT_THAT(source.error().message, HasSubstr("/reel.json: "));
  EXPECT_EQ(source.error().message.find('\n'), std::string::npos);
}

TEST(HttpSource, reports_that_nothing_answers) {
  std::string url;
  {
    url = ScriptedHttpServer([](int, const std::string&) { return false; }).url();
  }
  EXPECT_THAT(open_source(url, patient()).error().message, HasSubstr("nothing answers there"));
}

TEST(HttpSource, a_file_that_a_server_without_ranges_has_shorter_or_longer_is_an_error) {
  int requests = 0;
  const auto long_file = [](int socket, const std::string&) {
    answer(socket, "200 OK", "", text_of(offsets(0, 31)));
    return true;
  };
  EXPECT_THAT(fetch_error(long_file, &requests),
              HasSubstr("30 bytes expected (the file is longer than its manifest says)"));
  EXPECT_LE(requests, 2);
  const auto short_file = [](int socket, const std::string&) {
    answer(socket, "200 OK", "", text_of(offsets(0, 29)));
    return true;
  };
  EXPECT_THAT(
      fetch_error(short_file, &requests),
      HasSubstr("29 bytes came instead of 30 (the file is shorter than its manifest says)"));
  EXPECT_LE(requests, 2);
}

TEST(HttpSource, fetches_whole_files_once_from_a_server_without_ranges) {
  std::atomic<int> files = 0;
  ScriptedHttpServer server(serving([&](int socket, const std::string& head) {
    ++files;
    const std::size_t total = head.find("base") != std::string::npos ? 30 : 8;
    answer(socket, "200 OK", "", text_of(offsets(0, total)));
    return true;
  }));
  SourceOptions options = patient();
  std::vector<std::string> said;
  options.say = [&](const std::string& line) { said.push_back(line); };
  auto source = open_source(server.url() + "/reel", options);
  ASSERT_TRUE(source) << source.error().message;
  ASSERT_TRUE((*source)->fetch({0}));
  const int fetched = files;
  for (int i = 0; i < 2; ++i) {
    const auto frame = (*source)->fetch({1});
    ASSERT_TRUE(frame) << frame.error().message;
    EXPECT_EQ(frame->layers[0].bytes, offsets(9, 21));
    EXPECT_EQ(frame->layers[1].bytes, offsets(5, 3));
  }
  EXPECT_EQ(files, fetched) << "they are kept";
  EXPECT_THAT(said, testing::ElementsAre(HasSubstr("sends whole files instead of ranges")));
  FetchRequest again{1};
  again.fresh = true;
  ASSERT_TRUE((*source)->fetch(again));
  // A machine that is busy may break a connection off and ask again.
  EXPECT_GE(files, fetched + 2) << "damaged ones are not";
}

TEST(HttpSource, fetches_no_whole_file_of_another_size_than_the_manifest_says) {
  const std::string error = fetch_error([](int socket, const std::string&) {
    answer(socket, "200 OK", "", text_of(offsets(0, 31)));
    return true;
  });
  EXPECT_THAT(error, HasSubstr("sends more than the 30 bytes expected"));
}

TEST(HttpSource, fetches_no_whole_file_that_is_too_large) {
  Manifest manifest = small_manifest();
  LayerFile& base = manifest.segments[0].layers[0];
  base.bytes = WholeFiles::kMostBytes + 1;
  base.frames[1] = {static_cast<std::uint32_t>(base.bytes - 20), 6, 5};
  ScriptedHttpServer server([&](int socket, const std::string& head) {
    const bool wants_manifest = head.find("reel.json") != std::string::npos;
    answer(socket, "200 OK", "", wants_manifest ? write_manifest(manifest) : "x");
    return true;
  });
  auto source = open_source(server.url(), patient());
  ASSERT_TRUE(source) << source.error().message;
  const auto frame = (*source)->fetch({0});
  ASSERT_FALSE(frame);
  EXPECT_THAT(frame.error().message, HasSubstr("has more than 512 MiB"));
}

TEST(HttpSource, refuses_a_range_that_was_not_requested) {
  EXPECT_THAT(
      fetch_error([](int socket, const std::string& head) {
        const RequestedRange range = range_of(head);
        answer(socket, "206 Partial Content",
               fmt::format("Content-Range: bytes {}-{}/30\r\n", range.first + 1, range.last + 1),
               text_of(offsets(1, 9)));
        return true;
      }),
      HasSubstr("bytes 1-9/30"));
}

TEST(HttpSource, refuses_an_answer_without_content_range) {
  EXPECT_THAT(fetch_error([](int socket, const std::string&) {
                answer(socket, "206 Partial Content", "", text_of(offsets(0, 9)));
                return true;
              }),
              HasSubstr("the server sends \"\""));
}

TEST(HttpSource, refuses_a_file_whose_size_has_changed) {
  EXPECT_THAT(fetch_error([](int socket, const std::string&) {
                answer(socket, "206 Partial Content", "Content-Range: bytes 0-8/31\r\n",
                       text_of(offsets(0, 9)));
                return true;
              }),
              HasSubstr("has changed"));
}

TEST(HttpSource, stops_reading_a_body_that_is_too_long) {
  EXPECT_THAT(fetch_error([](int socket, const std::string&) {
                answer(socket, "206 Partial Content", "Content-Range: bytes 0-8/30\r\n",
                       std::string(1 << 20, 'x'));
                return true;
              }),
              HasSubstr("more than the 9 bytes"));
}

TEST(HttpSource, retries_once_after_an_invalid_answer) {
  int requests = 0;
  EXPECT_THAT(fetch_error(
                  [](int socket, const std::string&) {
                    answer(socket, "206 Partial Content", "Content-Range: bytes 1-9/30\r\n",
                           text_of(offsets(1, 9)));
                    return true;
                  },
                  &requests),
              testing::AllOf(HasSubstr("has changed"), HasSubstr("2 attempts")));
  EXPECT_EQ(requests, 2);
}

TEST(HttpSource, retries_while_it_opens_a_package_and_finally_gives_up) {
  ScriptedHttpServer server([](int socket, const std::string&) {
    send_text(socket, "HTTP/1.1 200 OK\r\nContent-Length: 9\r\n\r\nabc");
    return false;
  });
  const auto source = open_source(server.url(), patient());
  ASSERT_FALSE(source);
  EXPECT_THAT(source.error().message,
              testing::AllOf(HasSubstr("broke after 3 bytes"), HasSubstr("3 attempts")));
  EXPECT_EQ(server.requests, 3);
}

TEST(HttpSource, keeps_retrying_a_fetch_until_it_succeeds) {
  std::atomic<int> asked{0};
  EXPECT_EQ(fetch_error([&](int socket, const std::string& head) {
              const int number = ++asked;
              if (number <= 2) return false;  // closes without a response
              if (number <= 6) {
                answer(socket, "503 Service Unavailable", "", "later");
                return true;
              }
              return serve_range(socket, head);
            }),
            "no error");
  EXPECT_EQ(asked, 7) << "there were more failures than opening a source allows";
}

TEST(HttpSource, resumes_a_download_at_the_byte_where_the_connection_broke) {
  std::mutex mutex;
  std::vector<std::size_t> begun;
  ScriptedHttpServer server(serving([&](int socket, const std::string& head) {
    const RequestedRange range = range_of(head);
    {
      const std::lock_guard lock(mutex);
      begun.push_back(range.first);
    }
    // Sends four bytes of the requested range, although more were promised.
    const std::size_t size = range.last - range.first + 1;
    send_text(socket, fmt::format("HTTP/1.1 206 Partial Content\r\nContent-Range: bytes {}-{}/30"
                                  "\r\nContent-Length: {}\r\n\r\n{}",
                                  range.first, range.last, size,
                                  text_of(offsets(range.first, std::min<std::size_t>(size, 4)))));
    return false;
  }));
  auto source = open_source(server.url() + "/reel", patient());
  ASSERT_TRUE(source);
  const auto frame = (*source)->fetch({1, {0, 1, false, false}});
  ASSERT_TRUE(frame) << frame.error().message;
  EXPECT_EQ(frame->layers[0].bytes, offsets(9, 10));
  EXPECT_THAT(begun, testing::ElementsAre(9, 13, 17));
}

TEST(HttpSource, reports_trouble_until_it_has_passed) {
  std::atomic<bool> well{false};
  ScriptedHttpServer server(serving([&](int socket, const std::string& head) {
    if (well) return serve_range(socket, head);
    answer(socket, "503 Service Unavailable", "", "later");
    return true;
  }));
  auto source = open_source(server.url() + "/reel", patient());
  ASSERT_TRUE(source);
  EXPECT_EQ((*source)->trouble(), std::nullopt);
  std::thread fetcher([&] { EXPECT_TRUE((*source)->fetch({0})); });
  std::optional<std::string> trouble;
  wait_until([&] { return (trouble = (*source)->trouble()).has_value(); });
  EXPECT_EQ(trouble, server.url().substr(7) + ": the server answers 503; trying again");
  well = true;
  fetcher.join();
  EXPECT_TRUE(wait_until([&] { return !(*source)->trouble(); }));
}

TEST(HttpSource, gives_up_on_a_silent_server) {
  ScriptedHttpServer server([](int, const std::string&) { return true; });
  SourceOptions options = patient();
  options.stall_timeout = milliseconds(50);
  EXPECT_THAT(open_source(server.url(), options).error().message,
              testing::AllOf(HasSubstr("no answer within"), HasSubstr("3 attempts")));
}

TEST(HttpSource, gives_up_on_a_server_that_sends_next_to_nothing) {
  SourceOptions options = patient();
  options.open_attempts = 1;
  const std::string heads[] = {"HTTP/1.1 200 OK\r\n",
                               "HTTP/1.1 200 OK\r\nContent-Length: 100000\r\n\r\n"};
  std::vector<std::jthread> players;  // at the same time, because each takes some seconds
  for (const std::string& begin : heads) {
    players.emplace_back([&options, begin] {
      std::atomic<bool> refused = false;
      ScriptedHttpServer server([&](int socket, const std::string&) {
        send_text(socket, begin);
        const std::string drop = begin.ends_with("\r\n\r\n") ? " " : "A: b\r\n";
        while (!refused) {
          send_text(socket, drop);
          wait_until([&] { return refused.load(); }, milliseconds(100));
        }
        return false;
      });
      const auto source = open_source(server.url(), options);
      refused = true;
      ASSERT_FALSE(source);
      EXPECT_THAT(source.error().message,
                  testing::AllOf(HasSubstr(" bytes came within "), testing::Not(HasSubstr("\n"))));
    });
  }
}

TEST(HttpSource, retries_over_a_new_connection_if_an_answer_stalls) {
  std::atomic<int> asked{0};
  SourceOptions options = patient();
  options.stall_timeout = milliseconds(300);
  EXPECT_EQ(fetch_error(
                [&](int socket, const std::string& head) {
                  if (++asked == 1) {
                    send_text(socket,
                              "HTTP/1.1 206 Partial Content\r\nContent-Range: bytes 0-8/30\r\n"
                              "Content-Length: 9\r\n\r\n");
                    return true;  // nothing follows
                  }
                  return serve_range(socket, head);
                },
                nullptr, options),
            "no error");
  EXPECT_GE(asked, 2);
}

TEST(HttpSource, fetches_the_layers_of_a_frame_concurrently) {
  std::mutex mutex;
  std::condition_variable both;
  int here = 0;
  ScriptedHttpServer server(serving([&](int socket, const std::string& head) {
    std::unique_lock lock(mutex);
    ++here;
    both.notify_all();
    const bool met = both.wait_for(lock, std::chrono::seconds(60), [&] { return here == 2; });
    EXPECT_TRUE(met) << "the requests are not made in parallel";
    lock.unlock();
    return serve_range(socket, head);
  }));
  auto source = open_source(server.url() + "/reel", patient());
  ASSERT_TRUE(source);
  EXPECT_TRUE((*source)->fetch({0}));
}

TEST(HttpSource, fails_at_once_after_cancel) {
  std::atomic<bool> asked{false};
  ScriptedHttpServer server(serving([&](int, const std::string&) { return asked = true; }));
  auto source = open_source(server.url() + "/reel", patient());
  std::thread canceller([&] {
    EXPECT_TRUE(wait_until([&] { return asked.load(); }));
    (*source)->cancel();
  });
  EXPECT_THAT((*source)->fetch({0}).error().message, HasSubstr("cancelled"));
  canceller.join();
  EXPECT_THAT((*source)->fetch({0}).error().message, HasSubstr("cancelled"));
}

TEST(HttpSource, stops_one_fetch_and_not_the_others) {
  std::atomic<bool> asked{false};
  ScriptedHttpServer server(serving([&](int socket, const std::string& head) {
    if (range_of(head).first == 0 && head.find("base") != std::string::npos) {
      asked = true;
      return true;  // frame 0 never arrives
    }
    return serve_range(socket, head);
  }));
  auto source = open_source(server.url() + "/reel", patient());
  ASSERT_TRUE(source);
  std::stop_source stop;
  std::thread fetcher([&] {
    FetchRequest request{0};
    request.stop = stop.get_token();
    EXPECT_THAT((*source)->fetch(request).error().message, HasSubstr("cancelled"));
  });
  EXPECT_TRUE(wait_until([&] { return asked.load(); }));
  EXPECT_TRUE((*source)->fetch({1}));
  stop.request_stop();
  fetcher.join();
  EXPECT_TRUE((*source)->fetch({1}));
}

TEST(HttpSource, reuses_the_connection_of_a_stopped_fetch_if_little_is_missing) {
  std::atomic<int> asked{0};
  std::atomic<bool> given_up{false};
  std::stop_source stop;
  ScriptedHttpServer server(serving([&](int socket, const std::string& head) {
    if (++asked == 1) {
      stop.request_stop();
      EXPECT_TRUE(wait_until([&] { return given_up.load(); }));
    }
    return serve_range(socket, head);
  }));
  auto source = open_source(server.url() + "/reel", patient());
  ASSERT_TRUE(source);
  FetchRequest request{0, {0, 1, false, false}};
  request.stop = stop.get_token();
  EXPECT_THAT((*source)->fetch(request).error().message, HasSubstr("cancelled"));
  given_up = true;
  // While the old response is still arriving, a second connection may be opened, but no third.
  for (int i = 0; i < 5; ++i) EXPECT_TRUE((*source)->fetch({1, {0, 1, false, false}}));
  EXPECT_LE(server.connections, 2);
}

TEST(HttpSource, sends_its_token_and_bypasses_caches_after_damage) {
  std::mutex mutex;
  std::string heads;
  ScriptedHttpServer server(serving([&](int socket, const std::string& head) {
    const std::lock_guard lock(mutex);
    heads += head + "\n";
    return serve_range(socket, head);
  }));
  SourceOptions options = patient();
  options.token = "open-sesame";
  auto source = open_source(server.url() + "/reel", options);
  ASSERT_TRUE(source);
  FetchRequest request{0, {0, 1, false, false}};
  ASSERT_TRUE((*source)->fetch(request));
  EXPECT_THAT(heads, HasSubstr("Authorization: Bearer open-sesame"));
  EXPECT_THAT(heads, testing::Not(HasSubstr("no-cache")));
  request.fresh = true;
  ASSERT_TRUE((*source)->fetch(request));
  EXPECT_THAT(heads, HasSubstr("Cache-Control: no-cache"));
}

TEST(HttpSource, fetches_only_the_missing_layers) {
  ScriptedHttpServer server(serving(serve_range));
  auto source = open_source(server.url() + "/reel", patient());
  ASSERT_TRUE(source);
  const FetchRequest request{1, {.first = 1}};
  const auto frame = (*source)->fetch(request);
  ASSERT_TRUE(frame);
  ASSERT_EQ(frame->layers.size(), 1u);
  EXPECT_EQ(frame->layers[0].bytes, offsets(5, 3));
  EXPECT_EQ(server.requests, 2);
}

TEST(HttpSource, counts_the_bytes_and_time_of_the_link) {
  ScriptedHttpServer server(serving(serve_range));
  auto source = open_source(server.url() + "/reel", patient());
  ASSERT_TRUE(source);
  const std::uint64_t before = (*source)->link_use().bytes;
  ASSERT_TRUE((*source)->fetch({1}));
  const LinkUse use = (*source)->link_use();
  EXPECT_EQ(use.bytes, before + 24);
  EXPECT_GT(use.round_trip.count(), 0);
  EXPECT_LE(use.receiving, use.busy);
}

}  // namespace
}  // namespace pointreel::http_source_test
