#include "client/scene/radiance_picture.h"

#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace pointreel::radiance_picture_test {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes with_header(const std::string& size) {
  const std::string text =
      "#?RADIANCE\n# a comment\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=1.0\n\n" + size + "\n";
  return Bytes(text.begin(), text.end());
}

void add(Bytes& bytes, std::initializer_list<int> more) {
  for (const int value : more) bytes.push_back(static_cast<std::uint8_t>(value));
}

/// 1 is a mantissa of 128 and an exponent of 129.
Bytes flat_picture() {
  Bytes bytes = with_header("-Y 2 +X 4");
  for (int i = 0; i < 8; ++i) add(bytes, {128, 64, 0, 129 + i % 2});
  return bytes;
}

/// Eight equal texels in each of four rows, one as a run and one as a list.
Bytes encoded_picture() {
  Bytes bytes = with_header("-Y 4 +X 8");
  for (int y = 0; y < 4; ++y) {
    add(bytes, {2, 2, 0, 8});
    add(bytes, {128 + 8, 128});
    add(bytes, {8, 128, 128, 128, 128, 128, 128, 128, 128});
    add(bytes, {128 + 4, 128, 128 + 4, 128});
    add(bytes, {128 + 8, 129 + y});
  }
  return bytes;
}

TEST(RadiancePicture, reads_flat_rows) {
  const auto map = parse_radiance(flat_picture());
  ASSERT_TRUE(map) << map.error().message;
  EXPECT_EQ(map->width, 4);
  EXPECT_EQ(map->height, 2);
  EXPECT_EQ(map->at(0, 0), glm::vec3(1.0f, 0.5f, 0.0f));
  EXPECT_EQ(map->at(3, 1), glm::vec3(2.0f, 1.0f, 0.0f));
}

TEST(RadiancePicture, reads_rows_with_runs) {
  const auto map = parse_radiance(encoded_picture());
  ASSERT_TRUE(map) << map.error().message;
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 8; ++x)
      EXPECT_EQ(map->at(x, y), glm::vec3(static_cast<float>(1 << y))) << x << ", " << y;
}

TEST(RadiancePicture, reduces_large_pictures_without_changing_their_light) {
  Bytes bytes = with_header("-Y 1024 +X 2048");
  for (int i = 0; i < 1024 * 2048; ++i) add(bytes, {128, 128, 128, i % 2 == 0 ? 129 : 0});
  const auto map = parse_radiance(bytes);
  ASSERT_TRUE(map) << map.error().message;
  EXPECT_EQ(map->height, 256);
  EXPECT_EQ(map->width, 512);
  EXPECT_FLOAT_EQ(map->at(100, 100).x, 0.5f);
}

TEST(RadiancePicture, refuses_every_picture_that_is_cut_off) {
  for (const Bytes& whole : {flat_picture(), encoded_picture()})
    for (std::size_t size = 0; size < whole.size(); ++size) {
      const auto map = parse_radiance(std::span(whole).first(size));
      ASSERT_FALSE(map) << size;
      EXPECT_EQ(map.error().message.find('\n'), std::string::npos);
    }
}

TEST(RadiancePicture, refuses_what_it_cannot_read_and_says_why) {
  const auto message = [](const Bytes& bytes) {
    const auto map = parse_radiance(bytes);
    return map ? std::string("it was read") : map.error().message;
  };
  EXPECT_NE(message(with_header("+Y 2 +X 4")).find("-Y HEIGHT +X WIDTH"), std::string::npos);
  EXPECT_NE(message(with_header("-Y 999999 +X 999999")).find("can be read"), std::string::npos);
  EXPECT_NE(message(with_header("-Y -2 +X 4")).find("can be read"), std::string::npos);
  const std::string png = "\x89PNG\r\n\x1a\n";
  EXPECT_NE(message(Bytes(png.begin(), png.end())).find("Radiance"), std::string::npos);
  Bytes old = with_header("-Y 2 +X 4");
  add(old, {128, 128, 128, 129, 1, 1, 1, 3});
  for (int i = 0; i < 8; ++i) add(old, {128, 128, 128, 129});
  EXPECT_NE(message(old).find("row 0"), std::string::npos);
  Bytes run = with_header("-Y 2 +X 8");
  add(run, {2, 2, 0, 8, 128 + 9, 1});
  EXPECT_NE(message(run).find("row 0 does not fit"), std::string::npos);
}

TEST(RadiancePicture, says_which_file_is_missing) {
  const auto map = load_environment("no-such-file.hdr");
  ASSERT_FALSE(map);
  EXPECT_EQ(map.error().code, ErrorCode::not_found);
  EXPECT_NE(map.error().message.find("no-such-file.hdr"), std::string::npos);
}

}  // namespace
}  // namespace pointreel::radiance_picture_test
