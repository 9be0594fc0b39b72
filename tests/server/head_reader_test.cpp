#include "server/service/head_reader.h"

#include <cstring>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

namespace pointreel::head_reader_test {
namespace {

using State = HeadReader::State;

constexpr std::string_view kHead =
    "GET /reel/reel.json HTTP/1.1\r\nHost: somewhere\r\nRange: bytes=1-2\r\n\r\n";

State feed(HeadReader& reader, std::string_view bytes) {
  std::memcpy(reader.space().data(), bytes.data(), bytes.size());
  reader.took(bytes.size());
  return reader.next();
}

TEST(HeadReader, reads_a_head_split_into_any_three_pieces) {
  for (std::size_t first = 1; first + 1 < kHead.size(); ++first) {
    for (std::size_t second = first + 1; second < kHead.size(); ++second) {
      HeadReader reader;
      ASSERT_EQ(feed(reader, kHead.substr(0, first)), State::kPart) << first;
      ASSERT_EQ(feed(reader, kHead.substr(first, second - first)), State::kPart) << second;
      ASSERT_EQ(feed(reader, kHead.substr(second)), State::kHead) << first << ", " << second;
      ASSERT_EQ(reader.request().target, "/reel/reel.json");
      ASSERT_EQ(reader.request().range, "bytes=1-2");
    }
  }
}

TEST(HeadReader, reads_successive_heads_byte_by_byte) {
  HeadReader reader;
  for (int i = 0; i < 3; ++i) {
    for (std::size_t at = 0; at < kHead.size(); ++at)
      ASSERT_EQ(feed(reader, kHead.substr(at, 1)),
                at + 1 < kHead.size() ? State::kPart : State::kHead);
    EXPECT_EQ(reader.request().target, "/reel/reel.json");
    EXPECT_EQ(reader.next(), State::kEmpty);
  }
}

}  // namespace
}  // namespace pointreel::head_reader_test
