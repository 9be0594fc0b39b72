// Every allocation fails once, one after another. Whatever was asked for then fails with an error,
// or works without that memory, nothing leaks, and the next attempt works.

#include <cstdio>
#include <functional>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "codec/live/live.h"
#include "codec/package/manifest.h"
#include "pointreel/chunks.h"
#include "server/relay/relay.h"
#include "server/service/head_reader.h"
#include "server/service/service.h"
#include "tests/alloc/frames.h"
#include "tests/alloc/heap.h"
#include "tests/live_frames.h"

namespace pointreel::no_memory_test {
namespace {

/// Calls `attempt` with each of its allocations failing in turn. It must leave nothing behind.
template <class Attempt>
void fail_each_allocation(const std::string& name, const Attempt& attempt) {
  attempt();  // makes what is made only once
  std::size_t nth = 0;
  for (bool happened = true; happened;) {
    const std::size_t before = heap::in_use();
    {
      const heap::Failure failure(++nth);
      attempt();
      happened = failure.happened();
    }
    ASSERT_EQ(heap::in_use(), before) << name << ": allocation " << nth << " of those that follow";
  }
  EXPECT_GT(nth, 1u) << name;
}

TEST(NoMemory, for_a_frame_is_an_error) {
  for (const Decoding& decoding : all_decodings(12)) {
    const std::size_t points = decoding.decode({}).value();
    int errors = 0;
    fail_each_allocation(decoding.name, [&] {
      const auto decoded = decoding.decode({});
      if (decoded) {
        EXPECT_EQ(*decoded, points) << decoding.name;
      } else {
        ++errors;
      }
    });
    EXPECT_GT(errors, 0) << decoding.name;
  }
}

TEST(NoMemory, for_a_frame_in_several_threads_is_an_error) {
  const Executor executor = [](int count, const std::function<void(int)>& body) {
    for (int i = 0; i < count; ++i) body(i);
  };
  for (const Decoding& decoding : all_decodings(12)) {
    fail_each_allocation(decoding.name, [&] { (void)decoding.decode({.executor = executor}); });
  }
}

TEST(NoMemory, for_a_manifest_is_an_error) {
  Manifest manifest;
  manifest.codec = "octree";
  manifest.entropy = "none";
  manifest.layer_names = {"base", "a-layer-with-a-name-that-is-not-short"};
  manifest.bounds.grow(glm::dvec3(0.0));
  Segment segment;
  segment.times_us = {0};
  segment.points = {1};
  segment.layers = {{"a-file-with-a-name-that-is-not-short", 1, 1, {{1, 0, 0}}},
                    {"another-file-with-a-name-that-is-not-short", 0, 1, {{0, 0, 0}}}};
  manifest.segments.push_back(segment);
  const std::string text = write_manifest(manifest);
  ASSERT_TRUE(parse_manifest(text)) << parse_manifest(text).error().message;
  fail_each_allocation("manifest", [&] { (void)parse_manifest(text); });
}

/// Calls `work`, which may lack memory. A server's connection would end then.
template <class Work>
void connection(const Work& work) {
  try {
    work();
  } catch (const std::bad_alloc&) {
  }
}

/// What a publisher sends: a hello and two frames. Made beforehand, because only the receiver is
/// to lack memory.
const std::vector<LiveMessage>& sent() {
  static const std::vector<LiveMessage> messages = [] {
    std::vector<LiveMessage> all = {publisher_message()};
    for (std::uint32_t frame = 0; frame < 2; ++frame) {
      for (std::uint8_t layer = 0; layer < 3; ++layer) all.push_back(layer_message(frame, layer));
    }
    return all;
  }();
  return messages;
}

/// Like a connection, ends at the first error.
void publish_all(Publication& publication) {
  for (const LiveMessage& message : sent()) {
    if (!publication.message(message)) return;
  }
}

TEST(NoMemory, for_a_live_message_ends_a_connection_but_not_the_stream) {
  fail_each_allocation("relay", [] {
    std::unique_ptr<Relay> relay;
    connection([&] { relay = std::make_unique<Relay>(); });
    if (!relay) return;
    std::unique_ptr<Viewer> viewer;
    connection([&] {
      const auto publication = relay->publish("stage");
      if (!publication) return;
      (void)(*publication)->message(sent().front());
      auto joined = relay->join("stage", [] {});
      if (joined) viewer = *std::move(joined);
      publish_all(**publication);
    });
    connection([&] {
      while (viewer && viewer->next()) {
      }
    });
    // Another publisher has the stream now.
    connection([&] {
      auto publication = relay->publish("stage");
      if (publication) publish_all(**publication);
    });
  });
}

TEST(NoMemory, leaves_a_stream_as_good_as_before) {
  bool happened = true;
  for (std::size_t nth = 1; happened; ++nth) {
    Relay relay;
    std::unique_ptr<Publication> first = relay.publish("stage").value();
    ASSERT_TRUE(first->message(sent().front()));
    const auto viewer = relay.join("stage", [] {}).value();
    {
      const heap::Failure failure(nth);
      connection([&] { publish_all(*first); });
      connection([&] {
        first->end();
        first.reset();
      });
      happened = failure.happened();
    }
    while (viewer->next()) {
    }
    const auto second = relay.publish("stage").value();
    ASSERT_TRUE(second->message(publisher_message(2)));
    for (std::uint8_t layer = 0; layer < 3; ++layer) {
      ASSERT_TRUE(second->message(layer_message(0, layer)));
    }
    std::string seen;
    while (const auto message = viewer->next()) seen += brief(*message) + " ";
    EXPECT_EQ(seen, "hello 0.0 0.1 0.2 ") << "after allocation " << nth;
  }
}

TEST(NoMemory, for_a_request_ends_its_connection) {
  Relay relay;
  ServiceOptions options;
  options.log = Log::Level::kOff;
  Service service(*Catalog::load({}), &relay, options);
  for (const std::string target : {"/", "/healthz", "/metrics", "/nothing-of-this-name-is-here",
                                   "/live/nobody-has-published-this/reel.json"}) {
    const std::string head =
        "GET " + target + " HTTP/1.1\r\nHost: somewhere-with-a-long-name\r\n\r\n";
    int whole = 0;
    fail_each_allocation(target, [&] {
      connection([&] {
        HeadReader reader;
        const auto space = reader.space();
        ASSERT_GE(space.size(), head.size());
        std::copy(head.begin(), head.end(), space.begin());
        reader.took(head.size());
        if (reader.next() != HeadReader::State::kHead) return;
        Peer peer;
        const auto answer = service.answer(reader.request(), peer, [] {});
        if (const auto* response = std::get_if<Response>(&answer)) {
          whole += !write_head(*response, reader.keep_alive(), 0).empty();
        }
      });
    });
    EXPECT_GT(whole, 0) << target;
  }
}

}  // namespace
}  // namespace pointreel::no_memory_test
