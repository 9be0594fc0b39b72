#include "codec/files/picture.h"

#include <array>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <png.h>
#include <turbojpeg.h>
#include <zlib.h>

#include "tests/depth_scene.h"
#include "tests/view.h"

namespace pointreel::picture_test {
namespace {

using testing::HasSubstr;

constexpr std::uint64_t kMany = 1u << 26;

/// A PNG file of 5 x 7 pixels whose rows are filled with consecutive bytes.
std::string png_of(int bits, int kind, int interlace) {
  constexpr png_uint_32 kWidth = 5, kHeight = 7;
  std::string bytes;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(
      png, &bytes,
      [](png_structp p, png_bytep data, std::size_t size) {
        static_cast<std::string*>(png_get_io_ptr(p))->append(reinterpret_cast<char*>(data), size);
      },
      nullptr);
  png_set_IHDR(png, info, kWidth, kHeight, bits, kind, interlace, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  std::vector<png_color> palette(256);
  for (std::size_t i = 0; i < palette.size(); ++i)
    palette[i] = {static_cast<png_byte>(i), static_cast<png_byte>(2 * i), 7};
  if (kind == PNG_COLOR_TYPE_PALETTE) png_set_PLTE(png, info, palette.data(), 1 << bits);
  png_set_gAMA(png, info, 0.5);
  png_text comment{};
  comment.compression = PNG_TEXT_COMPRESSION_zTXt;
  std::string key = "Comment", text(100'000, 'x');
  comment.key = key.data();
  comment.text = text.data();
  comment.text_length = text.size();
  png_set_text(png, info, &comment, 1);
  png_write_info(png, info);
  std::vector<std::vector<png_byte>> rows(kHeight,
                                          std::vector<png_byte>(png_get_rowbytes(png, info)));
  std::vector<png_bytep> pointers;
  png_byte next = 0;
  for (auto& row : rows) {
    for (png_byte& byte : row) byte = next++;
    pointers.push_back(row.data());
  }
  png_write_image(png, pointers.data());
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return bytes;
}

std::string jpeg_of(const ColorPicture& picture) {
  const tjhandle jpeg = tjInitCompress();
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  tjCompress2(jpeg, picture.rgb.data(), static_cast<int>(picture.width), 0,
              static_cast<int>(picture.height), TJPF_RGB, &bytes, &size, TJSAMP_444, 95, 0);
  std::string out(reinterpret_cast<const char*>(bytes), size);
  tjFree(bytes);
  tjDestroy(jpeg);
  return out;
}

std::string error_of_depth(const std::string& bytes, std::uint64_t most = kMany) {
  const auto picture = read_depth_picture(view(bytes), most);
  return picture ? "it was read" : picture.error().message;
}
std::string error_of_color(const std::string& bytes, std::uint64_t most = kMany) {
  const auto picture = read_color_picture(view(bytes), most);
  return picture ? "it was read" : picture.error().message;
}

TEST(Picture, depth_is_read_as_it_stands_in_the_file_whatever_its_gamma_and_order) {
  for (const int interlace : {PNG_INTERLACE_NONE, PNG_INTERLACE_ADAM7}) {
    const auto picture =
        read_depth_picture(view(png_of(16, PNG_COLOR_TYPE_GRAY, interlace)), kMany);
    ASSERT_TRUE(picture) << picture.error().message;
    EXPECT_EQ(picture->width, 5u);
    EXPECT_EQ(picture->height, 7u);
    ASSERT_EQ(picture->values.size(), 35u);
    for (std::size_t i = 0; i < 35; ++i) EXPECT_EQ(picture->values[i], 514 * i + 1);
  }
  const auto pgm = read_depth_picture(view(std::string("P5\n2 1\n65535\n\x01\x02\xff\xfe")), kMany);
  ASSERT_TRUE(pgm) << pgm.error().message;
  EXPECT_THAT(pgm->values, testing::ElementsAre(0x0102, 0xfffe));
}

TEST(Picture, depth_of_another_kind_is_refused_by_its_name) {
  EXPECT_THAT(error_of_depth(png_of(8, PNG_COLOR_TYPE_GRAY, 0)),
              HasSubstr("is grey, of 8 bits; depth is grey, of 16 bits"));
  EXPECT_THAT(error_of_depth(png_of(8, PNG_COLOR_TYPE_RGB, 0)), HasSubstr("is coloured, of 8"));
  EXPECT_THAT(error_of_depth(png_of(8, PNG_COLOR_TYPE_PALETTE, 0)), HasSubstr("by a palette"));
  EXPECT_THAT(error_of_depth(png_of(16, PNG_COLOR_TYPE_GRAY_ALPHA, 0)),
              HasSubstr("grey with transparency, of 16"));
  EXPECT_THAT(error_of_depth(jpeg_of(depth_scene::color(depth_scene::camera(), 0))),
              HasSubstr("JPEG file, which loses depth"));
  EXPECT_THAT(error_of_depth("P5\n2 1\n255\nab"), HasSubstr("other than 16 bits"));
  EXPECT_THAT(error_of_depth("GIF89a"), HasSubstr("not a PNG file"));
}

TEST(Picture, colors_of_every_kind_of_png_are_read) {
  struct Case {
    int bits, kind;
    std::array<std::uint8_t, 3> second;  ///< pixel
  };
  for (const Case& c :
       {Case{8, PNG_COLOR_TYPE_RGB, {3, 4, 5}}, Case{8, PNG_COLOR_TYPE_RGB_ALPHA, {4, 5, 6}},
        Case{8, PNG_COLOR_TYPE_GRAY, {1, 1, 1}}, Case{8, PNG_COLOR_TYPE_GRAY_ALPHA, {2, 2, 2}},
        Case{8, PNG_COLOR_TYPE_PALETTE, {1, 2, 7}}, Case{16, PNG_COLOR_TYPE_RGB, {6, 8, 10}},
        Case{1, PNG_COLOR_TYPE_GRAY, {0, 0, 0}}}) {
    for (const int interlace : {PNG_INTERLACE_NONE, PNG_INTERLACE_ADAM7}) {
      const auto picture = read_color_picture(view(png_of(c.bits, c.kind, interlace)), kMany);
      ASSERT_TRUE(picture) << picture.error().message;
      ASSERT_EQ(picture->rgb.size(), 3u * 35u);
      for (std::size_t i = 0; i < 3; ++i)
        EXPECT_EQ(picture->rgb[3 + i], c.second[i]) << c.bits << " bits, kind " << c.kind;
    }
  }
}

TEST(Picture, colors_of_jpeg_and_ppm_are_read) {
  const ColorPicture color = depth_scene::color(depth_scene::camera(), 3);
  const auto jpeg = read_color_picture(view(jpeg_of(color)), kMany);
  ASSERT_TRUE(jpeg) << jpeg.error().message;
  ASSERT_EQ(jpeg->rgb.size(), color.rgb.size());
  double error = 0.0;
  for (std::size_t i = 0; i < color.rgb.size(); ++i) error += std::abs(jpeg->rgb[i] - color.rgb[i]);
  EXPECT_LT(error / static_cast<double>(color.rgb.size()), 2.0);
  const auto ppm = read_color_picture(view("P6\n1 2\n255\nabcdef"), kMany);
  ASSERT_TRUE(ppm) << ppm.error().message;
  EXPECT_EQ(ppm->rgb, Bytes({'a', 'b', 'c', 'd', 'e', 'f'}));
}

TEST(Picture, no_more_pixels_are_read_than_are_accepted) {
  const std::string depth = png_of(16, PNG_COLOR_TYPE_GRAY, 0);
  EXPECT_THAT(error_of_depth(depth, 34), HasSubstr("has 5 x 7 pixels; at most 34"));
  EXPECT_EQ(error_of_depth(depth, 35), "it was read");
  EXPECT_THAT(error_of_color(jpeg_of(depth_scene::color(depth_scene::camera(), 0)), 100),
              HasSubstr("has 160 x 120 pixels; at most 100"));
  EXPECT_THAT(error_of_color("P6\n4000000000 4000000000\n255\n"), HasSubstr("at most"));
  EXPECT_THAT(error_of_depth("P5\n0 3\n65535\n"), HasSubstr("has no pixels"));
  // A header that promises a million pixels on each side, with its checksum.
  std::string huge = depth;
  const unsigned char size[] = {0, 15, 66, 64, 0, 15, 66, 64};
  std::memcpy(huge.data() + 16, size, sizeof(size));
  const uLong crc = crc32(0, reinterpret_cast<const Bytef*>(huge.data() + 12), 17);
  for (std::size_t i = 0; i < 4; ++i) huge[29 + i] = static_cast<char>(crc >> (24 - 8 * i));
  EXPECT_THAT(error_of_depth(huge), HasSubstr("1000000 x 1000000 pixels; at most 67108864"));
}

TEST(Picture, what_is_cut_or_damaged_is_an_error_in_one_line_or_another_picture) {
  const ColorPicture color = depth_scene::color(depth_scene::camera(), 0);
  const std::string depth = depth_scene::png(depth_scene::depth(depth_scene::camera(), 0));
  for (const std::string& whole : {depth, depth_scene::png(color), jpeg_of(color)}) {
    for (std::size_t size = 0; size < whole.size(); size += 1 + size / 3) {
      const std::string cut = whole.substr(0, size);
      for (const std::string& error : {error_of_depth(cut), error_of_color(cut)}) {
        EXPECT_NE(error, "it was read") << "the first " << size << " bytes";
        EXPECT_EQ(error.find('\n'), std::string::npos);
      }
    }
    for (std::size_t at = 0; at < whole.size(); at += 1 + whole.size() / 200) {
      std::string damaged = whole;
      damaged[at] = static_cast<char>(damaged[at] ^ 0x55);
      EXPECT_EQ(error_of_depth(damaged).find('\n'), std::string::npos);
      EXPECT_EQ(error_of_color(damaged).find('\n'), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace pointreel::picture_test
