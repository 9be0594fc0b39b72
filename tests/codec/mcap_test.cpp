#include "codec/files/mcap.h"

#include <random>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codec/files/cloud_file.h"
#include "tests/ros_messages.h"
#include "tests/temporary_folder.h"

namespace pointreel::mcap_test {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using W = McapWriter;

constexpr const char* kClouds = "sensor_msgs/msg/PointCloud2";

Result<std::shared_ptr<const McapRecording>> open(const Bytes& bytes, const std::string& topic = {},
                                                  std::uint64_t max_memory = ~std::uint64_t{0}) {
  return McapRecording::open(ByteSource(ByteView(bytes)), topic, max_memory);
}

std::string error_of(const Bytes& bytes, const std::string& topic = {}) {
  const auto recording = open(bytes, topic);
  return recording ? "it was read" : recording.error().message;
}

Bytes cloud(float x) {
  CloudMessage message = two_points();
  message.points[0][0] = x;
  return message.cdr();
}

Bytes described() { return W::schema(1, kClouds) + W::channel(1, 1, "/points"); }

/// Two chunks with two messages each, indexed or not.
Bytes recording(const std::string& compression, bool indexed,
                std::uint64_t spacing_ns = 100'000'000) {
  McapWriter out;
  for (std::uint64_t i = 0; i < 2; ++i) {
    Bytes records = described();
    std::vector<std::pair<std::uint64_t, std::uint64_t>> entries;
    for (std::uint64_t j = 0; j < 2; ++j) {
      const std::uint64_t time = 1'000'000'000 + spacing_ns * (2 * i + j);
      entries.emplace_back(time, records.size());
      records = records + W::message(1, time, cloud(static_cast<float>(2 * i + j)));
    }
    out.add_chunk(records, compression);
    if (indexed) out.add_index(1, entries);
  }
  out.end();
  return out.bytes();
}

TEST(Mcap, messages_are_found_in_chunks_of_any_compression_with_and_without_an_index) {
  for (const std::string compression : {"", "zstd", "lz4"}) {
    for (const bool indexed : {true, false}) {
      const Bytes bytes = recording(compression, indexed);
      const auto opened = open(bytes);
      ASSERT_TRUE(opened) << opened.error().message;
      ASSERT_EQ((*opened)->size(), 4u);
      for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_EQ((*opened)->time_ns(i), 1'000'000'000 + 100'000'000 * i);
        const auto read = (*opened)->read(i);
        ASSERT_TRUE(read) << read.error().message;
        EXPECT_EQ(*read, cloud(static_cast<float>(i)));
      }
    }
  }
}

TEST(Mcap, messages_outside_of_chunks_are_put_in_order) {
  McapWriter out;
  out.add(described() + W::message(1, 30, cloud(3)) + W::message(1, 10, cloud(1)));
  out.end();
  const auto opened = open(out.bytes());
  ASSERT_TRUE(opened) << opened.error().message;
  ASSERT_EQ((*opened)->size(), 2u);
  EXPECT_EQ((*opened)->read(0).value(), cloud(1));
}

TEST(Mcap, among_several_topics_one_must_be_chosen) {
  McapWriter out;
  out.add(W::schema(1, kClouds) + W::schema(2, "sensor_msgs/msg/Image"));
  out.add(W::channel(1, 1, "/front") + W::channel(2, 1, "/back") + W::channel(3, 2, "/camera"));
  out.add(W::message(1, 1, cloud(1)) + W::message(2, 2, cloud(2)) + W::message(2, 3, cloud(3)) +
          W::message(3, 4, {1, 2, 3}));
  out.end();
  EXPECT_THAT(error_of(out.bytes()), HasSubstr("/back (2), /front (1); choose one by --topic"));
  EXPECT_THAT(error_of(out.bytes(), "/side"), HasSubstr("no point clouds of the topic /side"));
  EXPECT_THAT(error_of(out.bytes(), "/camera"), HasSubstr("no point clouds of the topic /camera"));
  EXPECT_EQ(open(out.bytes(), "/back").value()->size(), 2u);
}

TEST(Mcap, a_recording_without_point_clouds_says_what_it_has) {
  McapWriter out;
  out.add(W::schema(1, "foxglove.PointCloud") + W::channel(1, 1, "/points", "protobuf") +
          W::message(1, 1, {1}));
  EXPECT_THAT(error_of(out.bytes()), HasSubstr("/points (foxglove.PointCloud in protobuf)"));
  EXPECT_THAT(error_of(McapWriter().bytes()), HasSubstr("has no messages"));
}

TEST(Mcap, a_recording_that_was_cut_is_read_up_to_there_even_within_a_chunk) {
  for (const std::string compression : {"", "zstd", "lz4"}) {
    // Noise, which is stored as it is: a message of a cut chunk that is there as a whole is read.
    std::mt19937 random(1);
    const auto noise = [&] {
      Bytes bytes(10'000);
      for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
      return bytes;
    };
    const Bytes first = noise(), second = noise(), third = noise();
    McapWriter out;
    out.add_chunk(described() + W::message(1, 1, first), compression);
    const std::size_t chunk = out.bytes().size();
    out.add_chunk(W::message(1, 2, second) + W::message(1, 3, third), compression);
    out.end();
    const Bytes whole = out.bytes();
    const Bytes part(whole.begin(), whole.begin() + static_cast<int>(chunk) + 15'000);
    const auto cut = open(part);
    ASSERT_TRUE(cut) << cut.error().message;
    const auto& loss = (*cut)->loss();
    EXPECT_THAT(loss.warnings, ElementsAre("ends early, at byte " + std::to_string(chunk) + " of " +
                                           std::to_string(chunk + 15'000) +
                                           ", within a chunk: what comes before is read"));
    EXPECT_EQ(loss.parts, 0u);
    ASSERT_EQ((*cut)->size(), 2u) << compression;
    EXPECT_EQ((*cut)->read(0).value(), first);
    EXPECT_EQ((*cut)->read(1).value(), second);
  }
}

TEST(Mcap, an_end_that_is_none_is_told) {
  const Bytes whole = recording("zstd", true);
  EXPECT_THAT((*open(whole))->loss().warnings, testing::IsEmpty());
  Bytes without_end(whole.begin(), whole.end() - 29 - 8);
  EXPECT_THAT((*open(without_end))->loss().warnings, ElementsAre(HasSubstr("ends early, at byte")));
  without_end.resize(without_end.size() + 100);  // zeros
  EXPECT_THAT((*open(without_end))->loss().warnings, ElementsAre(HasSubstr("ends early, at byte")));
  EXPECT_EQ((*open(without_end))->size(), 4u);
}

TEST(Mcap, damaged_chunks_can_be_left_out) {
  McapWriter out;
  const Bytes channels = described();
  out.add_chunk(channels + W::message(1, 1, cloud(1)), "zstd");
  out.add_index(1, {{1, channels.size()}});
  out.add_chunk(channels + W::message(1, 9, cloud(9)), "zip");
  out.add_index(1, {{9, channels.size()}});
  out.add_chunk(described() + W::message(1, 2, cloud(2)), "zstd", 0, false);
  out.add_chunk(described() + W::message(1, 3, cloud(3)), "lz4", 10);
  out.add_chunk(described() + W::message(1, 4, cloud(4)), "lz4");
  out.end();
  EXPECT_THAT(error_of(out.bytes()), HasSubstr("pack --best-effort leaves such parts out"));
  const auto opened =
      McapRecording::open(ByteSource(ByteView(out.bytes())), {}, ~std::uint64_t{0}, true);
  ASSERT_TRUE(opened) << opened.error().message;
  ASSERT_EQ((*opened)->size(), 2u);
  EXPECT_EQ((*opened)->read(1).value(), cloud(4));
  EXPECT_EQ((*opened)->loss().parts, 3u);
  EXPECT_THAT((*opened)->loss().warnings,
              ElementsAre(HasSubstr("compressed by 'zip'"), HasSubstr("chunk 1: its checksum"),
                          HasSubstr("chunk 2: ")));
}

TEST(Mcap, each_lie_is_an_error) {
  const auto chunk = [](auto... arguments) {
    McapWriter out;
    out.add_chunk(described() + W::message(1, 1, cloud(1)), arguments...);
    return error_of(out.bytes());
  };
  EXPECT_THAT(chunk("zip"), HasSubstr("compressed by 'zip'"));
  EXPECT_THAT(chunk("zstd", 10), HasSubstr("zstd is damaged"));
  EXPECT_THAT(chunk("lz4", 10), AllOf(HasSubstr("chunk 0"), HasSubstr("checksum")));
  EXPECT_THAT(chunk("zstd", 100'000), HasSubstr("unpacks to"));
  EXPECT_THAT(chunk("lz4", 100'000), HasSubstr("unpacks to"));
  EXPECT_THAT(chunk("zstd", std::uint64_t{1} << 62), HasSubstr("bytes of memory"));
  EXPECT_THAT(chunk("zstd", 0, false), HasSubstr("checksum"));
  EXPECT_THAT(chunk("", 0, false), HasSubstr("checksum"));

  // Indexes that point elsewhere.
  for (const std::uint64_t offset : {std::uint64_t{0}, std::uint64_t{3}, ~std::uint64_t{0}}) {
    for (const std::string compression : {"", "zstd"}) {
      McapWriter out;
      out.add_chunk(described() + W::message(1, 1, cloud(1)), compression);
      out.add_index(1, {{1, offset}});
      out.add(described());
      const auto opened = open(out.bytes());
      ASSERT_TRUE(opened) << opened.error().message;
      const auto read = (*opened)->read(0);
      ASSERT_FALSE(read);
      EXPECT_EQ(read.error().message.find('\n'), std::string::npos);
    }
  }
}

TEST(Mcap, a_recording_is_a_sequence_of_frames_at_the_times_of_its_messages) {
  const TemporaryFolder folder;
  const Bytes bytes = recording("lz4", true);
  const auto file = folder.write("walk.mcap", std::string(bytes.begin(), bytes.end()));
  const auto sequence = list_cloud_frames({folder.path()});
  ASSERT_TRUE(sequence) << sequence.error().message;
  ASSERT_EQ(sequence->frames.size(), 4u);
  EXPECT_THAT(sequence->times_us, ElementsAre(0, 100'000, 200'000, 300'000));
  EXPECT_EQ(sequence->fps, 10.0);
  EXPECT_EQ(sequence->end_us(), 400'000u);
  const auto loaded = read_cloud_frame(sequence->frames[3]);
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_EQ(loaded->cloud.world(0), glm::dvec3(3, 2, 3));
  EXPECT_EQ(sequence->frames[3].name(), file.string() + ": message 3");
  EXPECT_EQ(up_of_file(file), 'z');
  const auto fetched = fetch_cloud_frame(sequence->frames[2], 1 << 20);
  ASSERT_TRUE(fetched) << fetched.error().message;
  EXPECT_EQ(fetched->bytes, cloud(2));
  EXPECT_EQ(fetched->format, CloudFormat::point_cloud2);
}

TEST(Mcap, a_frame_rate_is_whole_where_only_rounding_to_microseconds_keeps_it_from_that) {
  const auto rate = [](std::uint64_t spacing_us) {
    const TemporaryFolder folder;
    const Bytes bytes = recording("", true, 1000 * spacing_us);
    folder.write("walk.mcap", std::string(bytes.begin(), bytes.end()));
    return list_cloud_frames({folder.path()})->fps;
  };
  EXPECT_EQ(rate(33'333), 30.0);
  EXPECT_EQ(rate(33'334), 30.0);
  EXPECT_NEAR(rate(33'367), 29.97, 0.001);
  EXPECT_NEAR(rate(99'990), 10.001, 0.0001);
  EXPECT_EQ(rate(3'000'000), 1.0 / 3.0);
}

}  // namespace
}  // namespace pointreel::mcap_test
