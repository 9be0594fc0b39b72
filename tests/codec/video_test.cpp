#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <random>
#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>

#include "codec/video/occupancy.h"
#include "codec/video/surface_voxels.h"
#include "codec/video/video_decoder.h"
#include "codec/video/video_group.h"
#include "codec/video_encode/av1_encoder.h"
#include "codec/video_encode/video_encoder.h"
#include "pointreel/cloud.h"
#include "tests/pointers_to.h"

namespace pointreel::video_test {
namespace {

constexpr int kSide = 128;
const glm::dvec3 kCorner(-3.0, 5.0, 1000.0);
constexpr double kPitch = 0.01;

/// The voxels of a sphere around a place in pixels, red above, with blue stripes.
PointCloud sphere(const glm::dvec3& center, double radius) {
  PointCloud cloud;
  cloud.origin = kCorner;
  for (int z = 0; z < kSide; ++z) {
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        const glm::dvec3 place(x + 0.5, y + 0.5, z + 0.5), away = place - center;
        if (std::abs(glm::length(away) - radius) > 0.5) continue;
        cloud.positions.emplace_back(kPitch * place);
        cloud.normals.emplace_back(glm::normalize(away));
        const bool stripe = static_cast<int>(away.x + 1000.0) / 8 % 2 == 0;
        cloud.colors.emplace_back(257 * (away.y > 0 ? 200 : 60), 257 * 90,
                                  257 * (stripe ? 180 : 40));
      }
    }
  }
  return cloud;
}

std::vector<PointCloud> moving_sphere(int frames) {
  std::vector<PointCloud> clouds;
  for (int i = 0; i < frames; ++i)
    clouds.push_back(sphere({60.0 + 1.5 * i, 64.0, 62.0 + 0.5 * i}, 50.0));
  return clouds;
}

VideoOptions options() {
  VideoOptions options;
  options.pitch = kPitch;
  options.side = kSide;
  options.depth_quantizer = 8;
  options.color_quantizer = 24;
  options.preset = 10;
  return options;
}

Chunks<ByteView> view(const Chunks<Bytes>& chunks) {
  return {chunks.geometry, chunks.colors, chunks.normals};
}

const std::vector<PointCloud>& frames() {
  static const std::vector<PointCloud> all = moving_sphere(5);
  return all;
}
const std::vector<Chunks<Bytes>>& encoded() {
  static const std::vector<Chunks<Bytes>> all =
      encode_video_group(pointers_to(frames()), kCorner, options()).value();
  return all;
}

TEST(Video, decodes_to_the_surface_and_its_colours) {
  VideoDecoder decoder;
  for (std::size_t i = 0; i < encoded().size(); ++i) {
    SCOPED_TRACE(i);
    const auto pictures = decoder.next(view(encoded()[i]));
    ASSERT_TRUE(pictures) << pictures.error().message;
    const PointCloud cloud = points_of(*pictures).value();
    const glm::dvec3 center =
        kCorner + kPitch * glm::dvec3(60.0 + 1.5 * static_cast<double>(i), 64.0,
                                      62.0 + 0.5 * static_cast<double>(i));
    ASSERT_GT(cloud.size(), frames()[i].size() / 3);
    ASSERT_TRUE(cloud.has_normals() && cloud.has_colors());
    std::size_t off = 0, turned = 0, red = 0;
    for (std::size_t p = 0; p < cloud.size(); ++p) {
      const glm::dvec3 away = (cloud.world(p) - center) / kPitch;
      off += std::abs(glm::length(away) - 50.0) > 1.0 ? 1 : 0;
      turned += glm::dot(glm::dvec3(cloud.normals[p]), glm::normalize(away)) < 0.9 ? 1 : 0;
      red += (cloud.colors[p].x > 257 * 130) == (away.y > 0) ? 1 : 0;
    }
    EXPECT_LE(off, cloud.size() / 500);
    EXPECT_LE(turned, cloud.size() / 50);
    EXPECT_GE(red, cloud.size() * 97 / 100);
  }
}

TEST(Video, has_a_quarter_of_the_points_where_a_view_shows_no_more) {
  VideoDecoder decoder;
  const VideoPictures pictures = decoder.next(view(encoded()[0])).value();
  const DecodedFrame all = frame_of(pictures).value();
  EXPECT_EQ(all.source_points, all.cloud.size());
  const glm::dvec3 center = kCorner + kPitch * glm::dvec3(60.0, 64.0, 62.0);
  std::size_t before = all.cloud.size();
  for (const int wider : {2, 4, 8}) {
    SCOPED_TRACE(wider);
    DecodeLimits limits;
    limits.spacing = wider * kPitch;
    const DecodedFrame frame = frame_of(pictures, limits).value();
    const PointCloud& cloud = frame.cloud;
    EXPECT_EQ(frame.source_points, all.source_points);
    EXPECT_GT(cloud.size(), before / 5);
    EXPECT_LT(cloud.size(), before / 3);
    before = cloud.size();
    double area = 0.0;
    std::size_t off = 0, turned = 0, red = 0;
    for (std::size_t p = 0; p < cloud.size(); ++p) {
      const glm::dvec3 away = (cloud.world(p) - center) / kPitch;
      off += std::abs(glm::length(away) - 50.0) > 0.5 * wider + 0.5 ? 1 : 0;
      turned += glm::dot(glm::dvec3(cloud.normals[p]), glm::normalize(away)) < 0.9 ? 1 : 0;
      red += (cloud.colors[p].x > 257 * 130) == (away.y > 0) ? 1 : 0;
      area += cloud.radii[p] / kPitch * cloud.radii[p] / kPitch;
    }
    EXPECT_LE(off, cloud.size() / 50);
    EXPECT_LE(turned, cloud.size() / 20);
    EXPECT_GE(red, cloud.size() * 92 / 100);
    // Views overlap a little.
    const double sphere = 4.0 * 3.14159 * 50.0 * 50.0;
    EXPECT_GT(area, sphere);
    EXPECT_LT(area, 1.5 * sphere);
  }
  DecodeLimits least;
  least.spacing = 1.9 * kPitch;
  EXPECT_EQ(frame_of(pictures, least)->cloud.size(), all.cloud.size());
}

TEST(Video, leaves_no_part_of_the_surface_out) {
  VideoDecoder decoder;
  const PointCloud cloud = points_of(decoder.next(view(encoded()[0])).value()).value();
  // Directions in which there is a point, in cells of a few degrees.
  constexpr int kCells = 24;
  std::vector<int> seen(kCells * kCells, 0), wanted(kCells * kCells, 0);
  const auto mark = [&](const PointCloud& of, std::vector<int>& cells) {
    for (std::size_t p = 0; p < of.size(); ++p) {
      const glm::dvec3 away =
          glm::normalize((of.world(p) - kCorner) / kPitch - glm::dvec3(60.0, 64.0, 62.0));
      const int u = std::min(
          kCells - 1, static_cast<int>((std::atan2(away.z, away.x) / 6.2832 + 0.5) * kCells));
      const int v = std::min(kCells - 1, static_cast<int>((away.y + 1.0) / 2.0 * kCells));
      cells[static_cast<std::size_t>(v * kCells + u)] = 1;
    }
  };
  mark(frames()[0], wanted);
  mark(cloud, seen);
  EXPECT_EQ(seen, wanted);
}

/// The voxels that the points of a cloud are in.
std::set<std::array<int, 3>> voxels_of(const PointCloud& cloud) {
  std::set<std::array<int, 3>> voxels;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::ivec3 cell(glm::floor((cloud.world(i) - kCorner) / kPitch));
    voxels.insert({cell.x, cell.y, cell.z});
  }
  return voxels;
}

TEST(Video, encodes_many_points_at_one_place_in_time_that_grows_with_them) {
  PointCloud cloud = sphere({60.0, 64.0, 62.0}, 20.0);
  const std::size_t surface = cloud.size();
  cloud.positions.resize(surface + 300'000, glm::vec3(0.2f, 0.3f, 0.4f));
  cloud.normals.resize(cloud.positions.size(), glm::vec3(1.0f, 0.0f, 0.0f));
  cloud.colors.resize(cloud.positions.size());
  const auto chunks = encode_video_group(pointers_to({&cloud, 1}), kCorner, options());
  ASSERT_TRUE(chunks) << chunks.error().message;
  VideoDecoder decoder;
  EXPECT_GT(points_of(decoder.next(view(chunks->front())).value())->size(), surface / 3);
}

TEST(SurfaceVoxels, are_those_of_the_source_again) {
  VideoDecoder decoder;
  const PointCloud points = points_of(decoder.next(view(encoded()[0])).value()).value();
  const PointCloud voxels = surface_voxels(points, kPitch);
  const auto wanted = voxels_of(frames()[0]), found = voxels_of(voxels);
  EXPECT_EQ(found.size(), voxels.size()) << "each once";
  std::size_t common = 0;
  for (const auto& voxel : wanted) common += found.contains(voxel) ? 1 : 0;
  EXPECT_GT(common, wanted.size() * 8 / 10);
  EXPECT_GT(common, found.size() * 8 / 10);
  std::size_t red = 0;
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    EXPECT_NEAR(glm::length(voxels.normals[i]), 1.0f, 1e-3f);
    const double up = (voxels.world(i).y - kCorner.y) / kPitch - 64.0;
    red += (voxels.colors[i].x > 257 * 130) == (up > 0.0) ? 1 : 0;
  }
  EXPECT_GE(red, voxels.size() * 97 / 100);
}

TEST(SurfaceVoxels, stay_within_what_cells_can_count) {
  PointCloud cloud;
  cloud.origin = kCorner;
  cloud.positions = {
      {0.5f, 0.5f, 0.5f}, {-0.5f, 0.5f, 0.5f}, {3e38f, 0.0f, 0.0f}, {0.5f, 0.5f, 0.5f}};
  EXPECT_EQ(surface_voxels(cloud, 1.0).size(), 2u) << "neither far away nor twice";
  cloud.normals = {{0.0f, 0.0f, 1.0f}, {0.0f, 0.0f, 0.0f}, {1.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -1.0f}};
  const PointCloud voxels = surface_voxels(cloud, 1.0);
  ASSERT_EQ(voxels.size(), 2u);
  EXPECT_EQ(voxels.positions[0], cloud.positions[1]) << "in the order of Morton keys";
  EXPECT_EQ(voxels.normals[1], glm::vec3(0.0f)) << "opposite normals have no mean";
  EXPECT_TRUE(surface_voxels(PointCloud(), 1.0).empty());
}

TEST(Video, is_smaller_from_frame_to_frame) {
  // What the frames share is coded once.
  EXPECT_LT(encoded()[2].geometry.size(), encoded()[0].geometry.size());
}

TEST(Video, is_the_same_from_any_number_of_threads) {
  VideoOptions many = options();
  many.threads = 4;
  many.executor = [](int count, const std::function<void(int)>& body) {
    for (int i = count; i-- > 0;) body(i);
  };
  EXPECT_EQ(encode_video_group(pointers_to(frames()), kCorner, many).value(), encoded());
}

TEST(Video, leaves_the_processors_to_other_programs_also_for_root) {
  int threads = 0;
  const auto encoded = encode_av1({.width = 64, .height = 64, .frames = 2}, [&](int, Yuv&) {
    for (const auto& thread : std::filesystem::directory_iterator("/proc/self/task")) {
      ++threads;
      EXPECT_NE(sched_getscheduler(std::atoi(thread.path().filename().c_str())), SCHED_FIFO);
    }
  });
  ASSERT_TRUE(encoded) << encoded.error().message;
  EXPECT_GT(threads, 10);
}

TEST(Video, begins_with_the_first_frame_of_a_group_and_goes_on_in_order) {
  VideoDecoder decoder;
  EXPECT_FALSE(decoder.next(view(encoded()[1])));
  EXPECT_TRUE(decoder.next(view(encoded()[0])));
  EXPECT_FALSE(decoder.next(view(encoded()[2]))) << "the second one was left out";
  EXPECT_TRUE(decoder.next(view(encoded()[0])));
  EXPECT_TRUE(decoder.next(view(encoded()[1])));
  EXPECT_TRUE(decoder.next(view(encoded()[0]))) << "a group may begin anew";
}

TEST(Video, has_no_colours_where_they_were_left_out) {
  VideoDecoder decoder;
  const auto without = decoder.next({encoded()[0].geometry, {}, {}});
  ASSERT_TRUE(without);
  EXPECT_FALSE(points_of(*without).value().has_colors());
}

TEST(Video, damaged_bytes_give_errors_or_points_and_nothing_worse) {
  std::mt19937 random(5);
  for (int round = 0; round < 60; ++round) {
    Chunks<Bytes> chunks = encoded()[0];
    Bytes& bytes = round % 2 == 0 ? chunks.geometry : chunks.colors;
    if (round % 3 == 0) {
      bytes.resize(random() % bytes.size());
    } else {
      bytes[random() % bytes.size()] ^= static_cast<std::uint8_t>(1 + random() % 255);
    }
    VideoDecoder decoder;
    EXPECT_FALSE(decoder.next(view(chunks)) && bytes != encoded()[0].geometry &&
                 bytes != encoded()[0].colors && !bytes.empty())
        << "a checksum covers every byte";
  }
}

TEST(Video, pictures_that_take_too_much_memory_are_refused_first) {
  DecodeLimits limits;
  limits.max_memory = 1 << 20;
  VideoDecoder decoder;
  const auto refused = decoder.next(view(encoded()[0]), limits);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::limit);
}

TEST(Video, memory_is_counted_by_the_points_and_not_as_if_pictures_were_full) {
  VideoFrameReader reader;
  const VideoGroup group = *reader.next(view(encoded()[0])).value().group;
  const std::uint64_t points =
      points_of(VideoDecoder().next(view(encoded()[0])).value()).value().size();
  ASSERT_LT(5 * points, 3 * group.pixels());
  DecodeLimits limits;
  limits.max_memory = 64 * group.pixels() + 90 * points;
  EXPECT_TRUE(VideoDecoder().next(view(encoded()[0]), limits));
  limits.max_memory = 64 * group.pixels() + 40 * points;
  const auto refused = VideoDecoder().next(view(encoded()[0]), limits);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::limit);
}

TEST(Video, options_out_of_range_and_clouds_without_normals_are_refused) {
  VideoOptions wrong = options();
  wrong.depth_quantizer = 64;
  EXPECT_EQ(encode_video_group(pointers_to(frames()), kCorner, wrong).error().code,
            ErrorCode::argument);
  std::vector<PointCloud> bare{frames()[0]};
  bare[0].normals.clear();
  EXPECT_EQ(encode_video_group(pointers_to(bare), kCorner, options()).error().code,
            ErrorCode::argument);
  EXPECT_EQ(encode_video_group({}, kCorner, options()).error().code, ErrorCode::argument);
  std::vector<PointCloud> mixed{frames()[0], frames()[1]};
  mixed[1].colors.clear();
  EXPECT_EQ(encode_video_group(pointers_to(mixed), kCorner, options()).error().code,
            ErrorCode::argument);
  VideoOptions tiny = options();
  tiny.pitch = 1e-31;
  EXPECT_EQ(encode_video_group(pointers_to(frames()), kCorner, tiny).error().code,
            ErrorCode::limit);
}

TEST(Video, points_that_no_view_holds_are_kept) {
  // Single points far from the sphere are patches of one pixel, which no view keeps.
  std::vector<PointCloud> clouds{frames()[0]};
  for (int i = 0; i < 10; ++i) {
    clouds[0].positions.emplace_back(kPitch * glm::dvec3(4.5 + 11.0 * i, 3.5, 4.5));
    clouds[0].normals.emplace_back(0.0f, -1.0f, 0.0f);
    clouds[0].colors.emplace_back(0, 0, 0);
  }
  const auto chunks = encode_video_group(pointers_to(clouds), kCorner, options());
  ASSERT_TRUE(chunks) << chunks.error().message;
  VideoDecoder decoder;
  const PointCloud cloud = points_of(decoder.next(view((*chunks)[0])).value()).value();
  for (int i = 0; i < 10; ++i) {
    const glm::dvec3 wanted = kCorner + kPitch * glm::dvec3(4.5 + 11.0 * i, 3.5, 4.5);
    double nearest = 1e9;
    for (std::size_t p = 0; p < cloud.size(); ++p)
      nearest = std::min(nearest, glm::length(cloud.world(p) - wanted));
    EXPECT_LT(nearest, 2.0 * kPitch) << i;
  }
}

TEST(Video, a_frame_of_nothing_but_single_points_keeps_their_colours) {
  std::vector<PointCloud> clouds(1);
  clouds[0].origin = kCorner;
  for (int i = 0; i < 10; ++i) {
    clouds[0].positions.emplace_back(kPitch * glm::dvec3(4.5 + 11.0 * i, 3.5, 4.5));
    clouds[0].normals.emplace_back(0.0f, -1.0f, 0.0f);
    clouds[0].colors.emplace_back(257 * 200, 257 * 40, 257 * 30);
  }
  const auto chunks = encode_video_group(pointers_to(clouds), kCorner, options());
  ASSERT_TRUE(chunks) << chunks.error().message;
  VideoDecoder decoder;
  const PointCloud cloud = points_of(decoder.next(view((*chunks)[0])).value()).value();
  EXPECT_EQ(cloud.size(), 10u);
  ASSERT_EQ(cloud.colors.size(), cloud.size());
  for (const glm::u16vec3& color : cloud.colors) EXPECT_GT(color.x, color.y + 257 * 60);
}

TEST(Video, an_empty_frame_is_a_frame_without_points) {
  std::vector<PointCloud> clouds(2);
  clouds[0] = frames()[0];
  clouds[1].origin = kCorner;
  const auto chunks = encode_video_group(pointers_to(clouds), kCorner, options());
  ASSERT_TRUE(chunks) << chunks.error().message;
  VideoDecoder decoder;
  EXPECT_FALSE(points_of(decoder.next(view((*chunks)[0])).value()).value().empty());
  const auto second = decoder.next(view((*chunks)[1]));
  ASSERT_TRUE(second) << second.error().message;
  EXPECT_TRUE(points_of(*second).value().empty());
}

VideoGroup small_group() {
  VideoGroup group;
  group.frames = 3;
  group.width = 128;
  group.height = 64;
  group.patches = {{.view = 1, .layer = 0, .x = 16, .y = 32, .width = 64, .height = 48},
                   {.view = 4, .layer = 2, .width = 64, .height = 64, .atlas_x = 64}};
  return group;
}

TEST(VideoGroup, is_read_as_it_was_written) {
  Bytes bytes;
  write_video_group(small_group(), bytes);
  const auto read = read_video_group(bytes);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_TRUE(read->rest.empty());
  Bytes again;
  write_video_group(read->group, again);
  EXPECT_EQ(again, bytes);
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_FALSE(read_video_group(ByteView(bytes).first(size))) << size;
}

TEST(VideoGroup, patches_lie_in_the_picture_and_do_not_overlap) {
  for (const Patch& wrong :
       {Patch{.view = 6, .width = 16, .height = 16}, Patch{.layer = 4, .width = 16, .height = 16},
        Patch{.width = 0, .height = 16}, Patch{.width = 16, .height = 16, .atlas_x = 128},
        Patch{.width = 16, .height = 16, .atlas_x = 32}}) {
    VideoGroup group = small_group();
    group.patches.push_back(wrong);
    Bytes bytes;
    write_video_group(group, bytes);
    EXPECT_FALSE(read_video_group(bytes));
  }
}

TEST(Occupancy, is_decoded_as_it_was_encoded) {
  const VideoGroup group = small_group();
  OccupancyCoder encoder(group), decoder(group);
  std::mt19937 random(3);
  for (int frame = 0; frame < 3; ++frame) {
    BlockMask blocks(group);
    for (const Patch& patch : group.patches)
      for (int y = 0; y < patch.height / kBlock; ++y)
        for (int x = 0; x < patch.width / kBlock; ++x)
          blocks.at(patch.atlas_x / kBlock + x, patch.atlas_y / kBlock + y) =
              random() % 3 == 0 ? 1 : 0;
    Bytes bytes;
    encoder.encode(blocks, bytes);
    const auto decoded = decoder.decode(bytes);
    ASSERT_TRUE(decoded);
    EXPECT_EQ(decoded->on, blocks.on);
  }
}

TEST(Occupancy, edges_of_blocks_are_rounded_off) {
  VideoGroup group = small_group();
  BlockMask blocks(group);
  blocks.at(4, 4) = 1;
  const std::vector<std::uint8_t> mask = pixel_mask(group, blocks);
  EXPECT_EQ(mask[17 * 128 + 17], 1);
  EXPECT_EQ(mask[16 * 128 + 16], 0) << "the corner of a block that stands alone";
  EXPECT_EQ(std::count(mask.begin(), mask.end(), 1), 12);
}

}  // namespace
}  // namespace pointreel::video_test
