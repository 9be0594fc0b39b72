#include "codec/files/numpy.h"

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zip.h>

#include "codec/files/cloud_file.h"
#include "codec/files/format_table.h"

namespace pointreel::numpy_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A file of one array, as numpy.save writes it.
template <class T>
Bytes npy(const std::string& descr, const std::string& shape, const std::vector<T>& numbers,
          bool by_columns = false) {
  std::string text = "{'descr': " + (descr[0] == '[' ? descr : "'" + descr + "'") +
                     ", 'fortran_order': " + (by_columns ? "True" : "False") +
                     ", 'shape': " + shape + ", }";
  text += '\n';
  Bytes bytes{0x93,
              'N',
              'U',
              'M',
              'P',
              'Y',
              1,
              0,
              static_cast<std::uint8_t>(text.size()),
              static_cast<std::uint8_t>(text.size() >> 8)};
  bytes.insert(bytes.end(), text.begin(), text.end());
  const auto* data = reinterpret_cast<const std::uint8_t*>(numbers.data());
  bytes.insert(bytes.end(), data, data + numbers.size() * sizeof(T));
  return bytes;
}

/// A compressed archive, as numpy.savez_compressed writes it.
Bytes npz(const std::vector<std::pair<std::string, Bytes>>& arrays) {
  zip_source_t* target = zip_source_buffer_create(nullptr, 0, 0, nullptr);
  zip_source_keep(target);
  zip_t* zip = zip_open_from_source(target, ZIP_CREATE | ZIP_TRUNCATE, nullptr);
  for (const auto& [name, bytes] : arrays) {
    zip_source_t* source = zip_source_buffer(zip, bytes.data(), bytes.size(), 0);
    zip_file_add(zip, (name + ".npy").c_str(), source, ZIP_FL_ENC_UTF_8);
  }
  EXPECT_EQ(zip_close(zip), 0);
  zip_stat_t stat;
  zip_source_stat(target, &stat);
  Bytes all(stat.size);
  zip_source_open(target);
  EXPECT_EQ(zip_source_read(target, all.data(), all.size()), static_cast<zip_int64_t>(all.size()));
  zip_source_close(target);
  zip_source_free(target);
  return all;
}

struct Read {
  PointCloud cloud;
  ReadNotes notes;
};

Result<Read> read(const Bytes& bytes, const Reading& reading = {},
                  const DecodeLimits& limits = {}) {
  EXPECT_EQ(format_of(bytes, ""), CloudFormat::numpy);
  ReadNotes notes;
  auto cloud = read_points(ByteSource(ByteView(bytes)), CloudFormat::numpy, limits, reading, notes);
  if (!cloud) return tl::unexpected(cloud.error());
  return Read{std::move(*cloud), std::move(notes)};
}

std::string error_of(const Bytes& bytes, const Reading& reading = {},
                     const DecodeLimits& limits = {}) {
  const auto result = read(bytes, reading, limits);
  return result ? "none" : result.error().message;
}

template <class T>
T swapped(T value) {
  auto bytes = std::bit_cast<std::array<std::uint8_t, sizeof(T)>>(value);
  std::reverse(bytes.begin(), bytes.end());
  return std::bit_cast<T>(bytes);
}

const std::vector<float> kTwo{1, 2, 3, 4, 5, 6};

TEST(Numpy, an_array_of_positions_is_a_cloud) {
  const auto is_two = [](const Bytes& bytes) {
    const auto got = read(bytes);
    ASSERT_TRUE(got) << got.error().message;
    EXPECT_THAT(got->cloud.positions, ElementsAre(glm::vec3(1, 2, 3), glm::vec3(4, 5, 6)));
  };
  is_two(npy("<f4", "(2, 3)", kTwo));
  is_two(npy("<f4", "(1, 2, 3)", kTwo));
  is_two(npy("<f8", "(2, 3)", std::vector<double>{1, 2, 3, 4, 5, 6}));
  is_two(npy("<f4", "(2, 3)", std::vector<float>{1, 4, 2, 5, 3, 6}, true));
  is_two(npy("<i8", "(2L, 3L)", std::vector<std::int64_t>{1, 2, 3, 4, 5, 6}));
  // Half floats: 1, 2, 3, 4, 5 and 6.
  is_two(npy("<f2", "(2, 3)",
             std::vector<std::uint16_t>{0x3c00, 0x4000, 0x4200, 0x4400, 0x4500, 0x4600}));
  std::vector<double> big;
  for (const double number : kTwo) big.push_back(swapped(number));
  is_two(npy(">f8", "(2, 3)", big));
}

TEST(Numpy, an_archive_has_positions_colors_normals_and_numbers) {
  const Bytes bytes =
      npz({{"points", npy("<f4", "(2, 3)", kTwo)},
           {"rgb", npy("|u1", "(2, 4)", std::vector<std::uint8_t>{255, 0, 1, 255, 2, 3, 4, 9})},
           {"normals", npy("<f4", "(2, 3)", std::vector<float>{0, 0, 1, 0, 1, 0})},
           {"label", npy("<i8", "(2,)", std::vector<std::int64_t>{7, 8})},
           {"valid", npy("|b1", "(2, 1)", std::vector<std::uint8_t>{1, 0})},
           {"pose", npy("<f8", "(4, 4)", std::vector<double>(16, 1.0))},
           {"frame", npy("<i8", "()", std::vector<std::int64_t>{3})},
           {"names", npy("<U2", "(2,)", std::vector<std::uint8_t>(16))}});
  const auto got = read(bytes);
  ASSERT_TRUE(got) << got.error().message;
  const PointCloud& cloud = got->cloud;
  EXPECT_THAT(cloud.positions, ElementsAre(glm::vec3(1, 2, 3), glm::vec3(4, 5, 6)));
  EXPECT_THAT(cloud.colors, ElementsAre(glm::u16vec3(65535, 0, 257), glm::u16vec3(514, 771, 1028)));
  EXPECT_THAT(cloud.normals, ElementsAre(glm::vec3(0, 0, 1), glm::vec3(0, 1, 0)));
  ASSERT_EQ(cloud.scalars.size(), 3u);
  EXPECT_EQ(cloud.scalars[0].name, "alpha");
  EXPECT_EQ(cloud.scalars[1].name, "label");
  EXPECT_THAT(cloud.scalars[1].values, ElementsAre(7, 8));
  EXPECT_EQ(cloud.scalars[2].name, "valid");
  EXPECT_THAT(cloud.scalars[2].values, ElementsAre(1, 0));
  EXPECT_THAT(got->notes.unread,
              ::testing::UnorderedElementsAre("pose (4, 4)", "frame ()", "names"));
}

TEST(Numpy, matrices_of_a_camera_are_no_positions) {
  const auto got = read(npz({{"K", npy("<f4", "(3, 3)", std::vector<float>(9, 1.0f))},
                             {"scan", npy("<f4", "(2, 3)", kTwo)},
                             {"pose", npy("<f8", "(4, 4)", std::vector<double>(16, 1.0))}}));
  ASSERT_TRUE(got) << got.error().message;
  EXPECT_THAT(got->cloud.positions, ElementsAre(glm::vec3(1, 2, 3), glm::vec3(4, 5, 6)));
}

TEST(Numpy, columns_are_guessed_or_named) {
  const Bytes bytes = npy("<f4", "(2, 6)",
                          std::vector<float>{1, 2, 3, 255, 0, 9,  //
                                             4, 5, 6, 0, 255, 8});
  const auto guessed = read(bytes);
  ASSERT_TRUE(guessed) << guessed.error().message;
  EXPECT_EQ(guessed->cloud.colors.at(0).x, 65535);
  const auto named = read(bytes, {{"z", "x", "y", "_", "heat", "_"}, 0.0});
  ASSERT_TRUE(named) << named.error().message;
  EXPECT_THAT(named->cloud.positions, ElementsAre(glm::vec3(2, 3, 1), glm::vec3(5, 6, 4)));
  EXPECT_THAT(named->cloud.scalars.at(0).values, ElementsAre(0, 255));
  EXPECT_EQ(error_of(bytes, {{"x", "y", "z"}, 0.0}),
            "positions (2, 6) is to be read as 3 columns; --columns names them for all files");
}

TEST(Numpy, fields_of_structured_arrays_are_read_by_their_names) {
  struct Item {
    float x, y, z;
    std::uint8_t r, g, b, pad;
  };
  const auto fields =
      read(npy("[('x', '<f4'), ('y', '<f4'), ('z', '<f4'), ('r', '|u1'), "
               "('g', '|u1'), ('b', '|u1'), ('_', '|V1')]",
               "(2,)", std::vector<Item>{{1, 2, 3, 1, 2, 3, 0}, {4, 5, 6, 0, 0, 255, 0}}));
  ASSERT_TRUE(fields) << fields.error().message;
  EXPECT_THAT(fields->cloud.positions, ElementsAre(glm::vec3(1, 2, 3), glm::vec3(4, 5, 6)));
  EXPECT_EQ(fields->cloud.colors.at(1).z, 65535);
  const auto vectors = read(npy("[('xyz', '<f4', (3,)), (('how hot', 'heat'), '<f4')]", "(2,)",
                                std::vector<float>{1, 2, 3, 10, 4, 5, 6, 20}));
  ASSERT_TRUE(vectors) << vectors.error().message;
  EXPECT_THAT(vectors->cloud.positions, ElementsAre(glm::vec3(1, 2, 3), glm::vec3(4, 5, 6)));
  EXPECT_THAT(vectors->cloud.scalars.at(0).values, ElementsAre(10, 20));
}

TEST(Numpy, padding_of_aligned_structures_is_not_said_to_be_unread) {
  struct Item {
    std::uint8_t label;
    float x, y, z;
  };
  const auto aligned =
      read(npy("[('label', '|u1'), ('', '|V3'), ('x', '<f4'), ('y', '<f4'), ('z', '<f4')]", "(2,)",
               std::vector<Item>{{1, 1, 2, 3}, {2, 4, 5, 6}}));
  ASSERT_TRUE(aligned) << aligned.error().message;
  EXPECT_THAT(aligned->cloud.positions, ElementsAre(glm::vec3(1, 2, 3), glm::vec3(4, 5, 6)));
  EXPECT_THAT(aligned->notes.unread, IsEmpty());
}

TEST(Numpy, names_may_be_empty) {
  const auto cloud =
      read(npz({{"", npy("<f4", "(6,)", kTwo)}, {"points", npy("<f4", "(2, 3)", kTwo)}}));
  ASSERT_TRUE(cloud) << cloud.error().message;
  EXPECT_THAT(cloud->notes.unread, ElementsAre("(unnamed) (6,)"));
}

TEST(Numpy, what_is_no_cloud_is_told) {
  EXPECT_EQ(error_of(npy("<f4", "(1000, 2, 3)", kTwo)),
            "has no array of positions, of the shape (N, 3) and called positions, points or xyz: "
            "it has positions (1000, 2, 3)");
  EXPECT_THAT(error_of(npy("|O", "(2, 3)", kTwo)), HasSubstr("no array of positions"));
  EXPECT_THAT(error_of(npy("<f4", "(3, 17)", std::vector<float>(51))),
              HasSubstr("it has positions (3, 17)"));
  EXPECT_THAT(error_of(npz({{"a", npy("<f4", "(2, 3)", kTwo)}, {"b", npy("<f4", "(2, 3)", kTwo)}})),
              HasSubstr("it has a (2, 3), b (2, 3)"));
  // With one field of objects, numpy pickles all.
  EXPECT_THAT(error_of(npy("[('x', '<u2'), ('y', '<u2'), ('z', '<u2'), ('label', '|O')]", "(2,)",
                           std::vector<std::uint8_t>(28))),
              HasSubstr("it has positions (2,) of objects"));
  EXPECT_EQ(error_of(npy("<f4", "(5, 3)", kTwo)), "positions (5, 3) ends after 24 of 60 bytes");
  EXPECT_EQ(error_of(npz({{"readme", Bytes(20, 'a')}})), "readme: is not an array of numpy");
  Bytes cut = npz({{"points", npy("<f4", "(2, 3)", kTwo)}});
  cut.resize(cut.size() - 10);
  EXPECT_THAT(error_of(cut), HasSubstr("zip archive that cannot be read"));
  EXPECT_EQ(error_of(npy("<f4", "(2, 3", kTwo)), "has a header that cannot be read");
}

TEST(Numpy, few_bytes_do_not_become_many_points) {
  const Bytes zeros = npz({{"points", npy("<f4", "(1000000, 3)", std::vector<float>(3000000))}});
  EXPECT_LT(zeros.size(), 100000u);
  EXPECT_THAT(error_of(zeros, {}, {.max_points = 1000}), HasSubstr("more than 1000 points"));
  EXPECT_THAT(error_of(zeros, {}, {.max_memory = 60u << 20}), HasSubstr("than the 60 MiB that"));
  EXPECT_EQ(error_of(zeros, {}, {.max_memory = 64u << 20}), "none");
  std::vector<std::pair<std::string, Bytes>> arrays{{"points", npy("<f4", "(2, 3)", kTwo)}};
  for (char name = 'a'; name < 'i'; ++name)
    arrays.emplace_back(std::string(1, name), npy("<f8", "(2,)", std::vector<double>{1, 2}));
  EXPECT_THAT(error_of(npz(arrays), {}, {.max_memory = 2 * 64}), HasSubstr("takes 16 bytes, more"));
  EXPECT_THAT(error_of(npy("<f4", "(60000000, 3)", kTwo)), HasSubstr("ends after 24 of"));
}

}  // namespace
}  // namespace pointreel::numpy_test
