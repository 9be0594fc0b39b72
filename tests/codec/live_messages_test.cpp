// The messages between publishers, relays and viewers.

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codec/core/json_fields.h"
#include "codec/core/reel_rules.h"
#include "codec/live/live.h"
#include "pointreel/chunks.h"
#include "tests/live_frames.h"
#include "tests/live_layer.h"

namespace pointreel::live_messages_test {
namespace {

using testing::HasSubstr;

LiveHello a_hello() {
  LiveHello hello;
  hello.name = "stage left";
  hello.session = 0x0123456789abcdef;
  hello.codec = "octree";
  hello.entropy = "context";
  hello.fps = 29.97;
  hello.up = 'z';
  hello.colors = true;
  hello.layer_names = {"base", "middle", "full"};
  hello.bounds = {{-1.5, 0.0, 2.0}, {1.0, 2.0, 3.0}};
  return hello;
}

LiveLayer a_layer(const Bytes& bytes) {
  LiveLayer layer;
  layer.frame = 77;
  layer.layer = 1;
  layer.layers = 3;
  layer.capture_us = 1'700'000'000'123'456;
  layer.points = 5;
  layer.sizes = {4, 2, 1};
  layer.bytes = bytes;
  return layer;
}

LiveHello parse_hello(const std::string& text) {
  return std::get<LiveHello>(parse_live_text(text).value());
}

TEST(LiveMessages, a_hello_is_parsed_as_it_was_written) {
  EXPECT_EQ(parse_hello(write_hello(a_hello())), a_hello());
  LiveHello nothing_yet = a_hello();
  nothing_yet.codec = "draco";
  nothing_yet.entropy.clear();
  nothing_yet.bounds = {};
  nothing_yet.up = {'y', true};
  EXPECT_EQ(parse_hello(write_hello(nothing_yet)), nothing_yet);
}

TEST(LiveMessages, an_error_in_a_hello_names_the_member) {
  const auto error_with = [](const std::string& from, const std::string& to) {
    std::string text = write_hello(a_hello());
    text.replace(text.find(from), from.size(), to);
    const auto parsed = parse_live_text(text);
    return parsed ? std::string() : parsed.error().message;
  };
  EXPECT_THAT(error_with("\"version\":1", "\"version\":2"), HasSubstr("version 2"));
  EXPECT_THAT(error_with("0123456789abcdef", "0123456789ABCDEF"), HasSubstr("session"));
  EXPECT_THAT(error_with("\"octree\"", "\"mesh\""), HasSubstr("codec"));
  EXPECT_THAT(error_with("\"context\"", "\"best\""), HasSubstr("entropy"));
  EXPECT_THAT(error_with("29.97", "-1"), HasSubstr("fps"));
  EXPECT_THAT(error_with("29.97", "1e-300"), HasSubstr("fps"));
  EXPECT_THAT(error_with("middle", std::string(65, 'm')), HasSubstr("layers"));
  EXPECT_THAT(error_with("[-1.5,0.0,2.0],\"max\":[1.0", "[-1.7e308,0.0,2.0],\"max\":[1.7e308"),
              HasSubstr("bounds: max"));
  EXPECT_THAT(error_with("\"up\":\"z\"", "\"up\":\"+z\""), HasSubstr("up"));
  EXPECT_THAT(error_with("\"middle\"", "\"base\""), HasSubstr("layers"));
  EXPECT_THAT(error_with("\"middle\"", "\"../middle\""), HasSubstr("layers"));
  EXPECT_THAT(error_with("-1.5", "15"), HasSubstr("bounds"));
  EXPECT_THAT(error_with("stage", "st\\u0007ge"), HasSubstr("name"));
  EXPECT_THAT(error_with("\"hello\"", "\"drops\""), HasSubstr("drops"));
  EXPECT_THAT(error_with("{", "["), HasSubstr("JSON"));
}

TEST(LiveMessages, the_hello_of_a_publisher_has_a_secret_and_no_session) {
  LiveSecret secret;
  for (std::size_t i = 0; i < secret.size(); ++i) secret[i] = static_cast<std::uint8_t>(17 * i);
  const std::string text = write_publisher_hello(a_hello(), {secret});
  EXPECT_THAT(text, HasSubstr(R"("secret":"00112233445566778899aabbccddeeff")"));
  EXPECT_THAT(text, testing::Not(HasSubstr("session")));
  const auto parsed = parse_publisher_text(text).value().value();
  EXPECT_EQ(parsed.identity.secret, secret);
  LiveHello without = a_hello();
  without.session = 0;
  EXPECT_EQ(parsed.hello, without);
  EXPECT_THAT(parse_live_text(text).error().message, HasSubstr("session: is missing"));
  EXPECT_THAT(parse_publisher_text(write_hello(a_hello())).error().message,
              HasSubstr("secret: is missing"));
  for (const char* wrong :
       {"", "00", "00112233445566778899aabbccddeef", "00112233445566778899aabbccddeeff0",
        "00112233445566778899AABBCCDDEEFF", "0x112233445566778899aabbccddeeff"}) {
    std::string changed = text;
    changed.replace(changed.find("0011"), 32, wrong);
    EXPECT_THAT(parse_publisher_text(changed).error().message, HasSubstr("secret")) << wrong;
  }
  EXPECT_FALSE(parse_publisher_text(R"({"type": "weather"})").value());
  EXPECT_FALSE(parse_publisher_text(write_end()));
}

TEST(LiveMessages, drops_and_the_end_are_parsed_and_unknown_types_are_distinguished) {
  const LiveDrops drops{3, 12};
  EXPECT_EQ(std::get<LiveDrops>(parse_live_text(write_drops(drops)).value()), drops);
  EXPECT_TRUE(std::holds_alternative<LiveEnd>(parse_live_text(write_end()).value()));
  EXPECT_TRUE(std::holds_alternative<LiveUnknown>(
      parse_live_text(R"({"type": "weather", "degrees": 21})").value()));
  EXPECT_FALSE(parse_live_text(R"({"frames": 1})"));
  EXPECT_FALSE(parse_live_text(R"({"type": "drops", "frames": -1, "layers": 0})"));
  EXPECT_FALSE(parse_live_text(std::string(kMaxLiveText + 1, ' ')));
}

TEST(LiveMessages, the_longest_hello_has_room) {
  LiveHello hello = a_hello();
  hello.name = std::string(kMaxTitle, '"');
  hello.layer_names.clear();
  for (char c = 'a'; hello.layer_names.size() < kMaxLayers; ++c) {
    hello.layer_names.emplace_back(kMaxLayerName, c);
  }
  hello.fps = 29.970029970029973;
  hello.bounds = {};
  hello.bounds.grow(glm::dvec3(-1.2345678901234567e-300));
  hello.bounds.grow(glm::dvec3(1.2345678901234567e+300));
  const std::string text = write_hello(hello);
  EXPECT_LT(text.size(), kMaxLiveText / 2);
  EXPECT_TRUE(std::get<LiveHello>(parse_live_text(text).value()) == hello);
}

TEST(LiveMessages, a_layer_is_parsed_as_it_was_written) {
  const Bytes bytes = {1, 2, 3, 4, 5, 6, 7};
  const Bytes message = write_live_layer(a_layer(bytes));
  EXPECT_EQ(message.size(), kLiveHeaderSize + bytes.size());
  const LiveLayer layer = parse_live_layer(message).value();
  EXPECT_EQ(layer.frame, 77u);
  EXPECT_EQ(layer.layer, 1);
  EXPECT_EQ(layer.layers, 3);
  EXPECT_EQ(layer.capture_us, 1'700'000'000'123'456u);
  EXPECT_EQ(layer.points, 5u);
  EXPECT_EQ(layer.sizes, (Chunks<std::uint32_t>{4, 2, 1}));
  EXPECT_TRUE(std::equal(layer.bytes.begin(), layer.bytes.end(), bytes.begin(), bytes.end()));
}

TEST(LiveMessages, a_layer_with_any_byte_of_its_header_changed_is_refused) {
  const Bytes bytes = {1, 2, 3, 4, 5, 6, 7};
  const Bytes message = write_live_layer(a_layer(bytes));
  for (std::size_t i = 0; i < kLiveHeaderSize; ++i) {
    Bytes changed = message;
    changed[i] ^= 0x10;
    EXPECT_FALSE(parse_live_layer(changed)) << "byte " << i;
  }
}

TEST(LiveMessages, a_layer_that_is_truncated_or_too_long_is_refused) {
  const Bytes bytes = {1, 2, 3, 4, 5, 6, 7};
  Bytes message = write_live_layer(a_layer(bytes));
  for (std::size_t size = 0; size < message.size(); ++size) {
    EXPECT_FALSE(parse_live_layer(ByteView(message).first(size))) << size << " bytes";
  }
  message.push_back(0);
  EXPECT_FALSE(parse_live_layer(message));
}

TEST(LiveMessages, a_layer_that_no_frame_can_have_is_refused) {
  const Bytes bytes = {1, 2, 3, 4, 5, 6, 7};
  const auto refused = [&](auto change) {
    LiveLayer layer = a_layer(bytes);
    change(layer);
    return !parse_live_layer(write_live_layer(layer));
  };
  EXPECT_TRUE(refused([](LiveLayer& layer) { layer.layer = 3; }));
  EXPECT_TRUE(refused([](LiveLayer& layer) { layer.layers = 0; }));
  EXPECT_TRUE(refused([](LiveLayer& layer) { layer.layers = 9; }));
  EXPECT_TRUE(refused([](LiveLayer& layer) { layer.capture_us = ~std::uint64_t{0}; }));
  EXPECT_TRUE(refused([](LiveLayer& layer) { layer.capture_us = kMaxCaptureTime + 1; }));
  EXPECT_FALSE(refused([](LiveLayer& layer) { layer.capture_us = kMaxCaptureTime; }));
  EXPECT_TRUE(refused([](LiveLayer& layer) { layer.sizes = {0, 6, 1}; }));
  EXPECT_TRUE(refused([](LiveLayer& layer) { layer.sizes.normals = 2; }));
  EXPECT_TRUE(refused([](LiveLayer& layer) { layer.sizes = {~0u, ~0u, ~0u}; }));
}

TEST(LiveMessages, a_stream_name_needs_no_escaping_in_a_url) {
  EXPECT_TRUE(is_stream_name("stage-1.left_A"));
  for (const char* name : {"", ".", "..", ".hidden", "a/b", "a b", "a?b", "é", "a%20b"}) {
    EXPECT_FALSE(is_stream_name(name)) << name;
  }
  EXPECT_TRUE(is_stream_name(std::string(64, 'a')));
  EXPECT_FALSE(is_stream_name(std::string(65, 'a')));
}

TEST(LiveMessages, a_hello_lists_scalar_fields) {
  LiveHello hello = a_hello();
  hello.scalars = {{"he said \"a\"", -1.25, 1e30, false}, {"class", 1, 6, true}};
  EXPECT_EQ(parse_hello(write_hello(hello)), hello);
  EXPECT_EQ(write_hello(a_hello()).find("scalars"), std::string::npos);
  hello.scalars[1].name = hello.scalars[0].name;
  EXPECT_THAT(parse_live_text(write_hello(hello)).error().message, HasSubstr("comes twice"));
}

TEST(LiveMessages, a_hello_names_the_servers_that_it_came_through) {
  LiveHello hello = plain_hello();
  hello.servers = {1, 0xfedc'ba98'7654'3210};
  const auto parsed = parse_live_text(write_hello(hello));
  ASSERT_TRUE(parsed) << parsed.error().message;
  EXPECT_EQ(std::get<LiveHello>(*parsed), hello);
  for (const char* bad : {R"("servers":5,)", R"("servers":["1"],)", R"("servers":[1],)",
                          R"("servers":["0000000000000001","000000000000000G"],)"}) {
    std::string text = write_hello(plain_hello());
    text.insert(1, bad);
    const auto refused = parse_live_text(text);
    ASSERT_FALSE(refused) << text;
    EXPECT_THAT(refused.error().message, HasSubstr("servers")) << text;
  }
  hello.servers.assign(kMaxLiveServers, 1);
  EXPECT_TRUE(parse_live_text(write_hello(hello)));
  hello.servers.push_back(1);
  EXPECT_FALSE(parse_live_text(write_hello(hello)));
}

TEST(LiveMessages, the_list_of_streams_is_parsed_as_it_was_written) {
  LiveStreams streams;
  EXPECT_EQ(std::get<LiveStreams>(parse_live_text(write_streams(streams)).value()), streams);
  for (std::size_t i = 0; i < kMaxLiveStreams; ++i)
    streams.names.push_back(std::string(62, 'x') + std::to_string(10 + i));
  EXPECT_EQ(std::get<LiveStreams>(parse_live_text(write_streams(streams)).value()), streams);
  streams.names.emplace_back("one-too-many");
  EXPECT_FALSE(parse_live_text(write_streams(streams)));
  for (const char* bad :
       {R"({"type":"streams"})", R"({"type":"streams","names":{}})",
        R"({"type":"streams","names":["a/b"]})", R"({"type":"streams","names":[7]})"}) {
    EXPECT_FALSE(parse_live_text(bad)) << bad;
  }
}

}  // namespace
}  // namespace pointreel::live_messages_test
