#include <gtest/gtest.h>

#include "codec/draco/part_sizes.h"
#include "pointreel/chunks.h"
#include "pointreel/codec.h"
#include "pointreel/draco.h"

namespace pointreel::registry_test {
namespace {

PointCloud two_points() {
  PointCloud cloud;
  cloud.positions = {{0.25f, 0.25f, 0.25f}, {0.75f, 0.75f, 0.75f}};
  cloud.normals = {{1, 0, 0}, {0, 1, 0}};
  cloud.colors = {{0, 257, 65535}, {514, 0, 0}};
  return cloud;
}

TEST(Registry, decodes_by_the_codec_that_the_frame_names) {
  for (const EncodeOptions& options :
       {EncodeOptions{OctreeOptions{}}, EncodeOptions{DracoOptions{}}}) {
    const auto frame = encode_frame(two_points(), Cube{}, options);
    ASSERT_TRUE(frame) << frame.error().message;
    const auto decoded = decode_frame(layer_views(frame->layers));
    ASSERT_TRUE(decoded) << decoded.error().message;
    EXPECT_EQ(decoded->cloud.size(), 2u);
    EXPECT_EQ(decoded->svo.has_value(), options.id() == Codec::octree);
  }
}

TEST(Registry, sizes_of_the_chunks_add_up_to_the_frame) {
  for (const EncodeOptions& options :
       {EncodeOptions{OctreeOptions{}}, EncodeOptions{DracoOptions{}}}) {
    const auto frame = encode_frame(two_points(), Cube{}, options);
    ASSERT_TRUE(frame);
    const auto parts = measure_part_sizes(*frame, two_points(), Cube{}, options);
    ASSERT_TRUE(parts);
    EXPECT_EQ(parts->geometry + parts->colors + parts->normals, frame->size());
  }
}

TEST(Registry, reports_an_error_without_layers_or_without_a_frame) {
  EXPECT_FALSE(decode_frame({}));
  EXPECT_FALSE(decode_frame({Chunks<ByteView>{}}));
  const Bytes noise(200, 0x5a);
  EXPECT_FALSE(decode_frame({Chunks<ByteView>{noise, {}, {}}}));
}

}  // namespace
}  // namespace pointreel::registry_test
