// Decoding a frame takes no more memory than DecodeLimits::max_memory allows, whatever the frame
// claims to be.

#include <cstdint>
#include <cstring>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codec/draco/drc_reader.h"
#include "codec/octree/frame_header.h"
#include "pointreel/chunks.h"
#include "pointreel/draco.h"
#include "tests/alloc/frames.h"
#include "tests/alloc/heap.h"
#include "tests/forge.h"

namespace pointreel::frame_memory_test {
namespace {

using testing::HasSubstr;

/// For the context tables and what the decoders need however small a frame is.
constexpr std::size_t kFixed = std::size_t{8} << 20;

TEST(FrameMemory, is_within_any_budget_and_the_budget_is_near_to_it) {
  for (const Decoding& decoding : all_decodings(100)) {
    (void)decoding.decode({});  // makes what is made only once
    std::size_t needed = 0;
    for (std::uint64_t budget = 1024; needed == 0; budget += budget / 2) {
      ASSERT_LT(budget, std::uint64_t{1} << 32) << decoding.name;
      const heap::Peak peak;
      const auto decoded = decoding.decode({.max_memory = budget});
      EXPECT_LE(peak.bytes(), budget + kFixed) << decoding.name << " with " << budget;
      if (!decoded) {
        EXPECT_EQ(decoded.error().code, ErrorCode::limit);
        EXPECT_THAT(decoded.error().message, HasSubstr("--frame-memory")) << decoding.name;
        continue;
      }
      needed = budget;
      EXPECT_LT(budget, 20 * (peak.bytes() + 4096)) << decoding.name;
    }
  }
}

/// A Draco frame of about a megabyte whose headers claim 2^26 points.
EncodedFrame bomb(DracoMethod method) {
  constexpr std::uint32_t kPoints = 1u << 26;
  PointCloud cloud;
  cloud.positions = {glm::vec3(0.1f), glm::vec3(0.9f)};
  DracoOptions options;
  options.method = method;
  EncodedFrame frame = encode_frame(cloud, Cube{}, {options}).value();
  Bytes& bytes = frame.layers[0].geometry;
  const std::size_t chunk = chunk_begin(0, ChunkKind::geometry);
  const ParsedFrameHeader parsed = read_frame_header(bytes).value();
  FrameHeader header = parsed.header;
  header.source_points = header.coded_points = kPoints;
  Bytes forged;
  write_frame_header(header, parsed.tag, forged);
  Bytes payload(bytes.begin() + static_cast<std::ptrdiff_t>(chunk + kChunkHeaderSize), bytes.end());
  put_at(payload, 11, kPoints);  // after Draco's fixed header
  if (method == DracoMethod::kd_tree) {
    // It comes once more, after the attribute's description, the level and the number of bits.
    for (std::size_t at = 15; at + 4 <= payload.size(); ++at) {
      const std::uint32_t two = 2;
      if (std::memcmp(payload.data() + at, &two, 4) != 0) continue;
      put_at(payload, at, kPoints);
      break;
    }
  }
  payload.resize(std::size_t{1} << 20);
  ChunkHeader chunk_header;
  chunk_header.raw_size = static_cast<std::uint32_t>(payload.size());
  write_chunk(chunk_header, parsed.tag, payload, forged);
  bytes = forged;
  return frame;
}

TEST(FrameMemory, is_not_taken_for_points_that_a_frame_only_claims_to_have) {
  for (const DracoMethod method : {DracoMethod::kd_tree, DracoMethod::sequential}) {
    const EncodedFrame frame = bomb(method);
    const heap::Peak peak;
    const auto decoded = decode_frame(layer_views(frame.layers));
    ASSERT_FALSE(decoded);
    EXPECT_EQ(decoded.error().code, ErrorCode::limit) << decoded.error().message;
    EXPECT_THAT(decoded.error().message, HasSubstr("more than the 1024 MiB of memory"));
    EXPECT_LT(peak.bytes(), kFixed);
  }
}

}  // namespace
}  // namespace pointreel::frame_memory_test
