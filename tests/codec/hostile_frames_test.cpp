// Small frames of every coding are damaged in every place, with the old checksums and with
// corrected ones. Each must give an error or a sound frame. Every chunk is copied to memory of
// exactly its size, so that the sanitizer notices reads past its end.

#include <algorithm>
#include <memory>

#include <gtest/gtest.h>

#include "pointreel/chunks.h"
#include "pointreel/codec.h"
#include "pointreel/draco.h"
#include "tests/forge.h"

namespace pointreel::hostile_frames_test {
namespace {

const DecodeLimits kLimits{1u << 16};

/// A copy of a chunk in memory of exactly its size.
class ExactCopy {
 public:
  explicit ExactCopy(ByteView bytes)
      : size_(bytes.size()), memory_(std::make_unique<std::uint8_t[]>(bytes.size())) {
    std::copy(bytes.begin(), bytes.end(), memory_.get());
  }
  ByteView view() const { return {memory_.get(), size_}; }

 private:
  std::size_t size_;
  std::unique_ptr<std::uint8_t[]> memory_;
};

Result<DecodedFrame> decode_exactly(const EncodedFrame& frame) {
  std::vector<ExactCopy> copies;
  std::vector<Chunks<ByteView>> views;
  for (const Chunks<Bytes>& layer : frame.layers) {
    for (const Bytes* part : {&layer.geometry, &layer.colors, &layer.normals}) {
      copies.emplace_back(*part);
    }
    const std::size_t n = copies.size();
    views.push_back({copies[n - 3].view(), copies[n - 2].view(), copies[n - 1].view()});
  }
  return decode_frame(views, kLimits);
}

void expect_sound(const Result<DecodedFrame>& frame) {
  if (!frame) {
    EXPECT_FALSE(frame.error().message.empty());
    return;
  }
  const PointCloud& cloud = frame->cloud;
  EXPECT_LE(cloud.size(), kLimits.max_points);
  EXPECT_TRUE(cloud.colors.empty() || cloud.colors.size() == cloud.size());
  EXPECT_TRUE(cloud.normals.empty() || cloud.normals.size() == cloud.size());
  if (frame->svo) {
    EXPECT_EQ(frame->svo->leaf_count(), cloud.size());
  }
  for (const glm::vec3& p : cloud.positions) {
    ASSERT_TRUE(p.x >= 0 && p.y >= 0 && p.z >= 0);
    ASSERT_LE(std::max({p.x, p.y, p.z}), 1.00001 * frame->cube.edge);
  }
}

struct Coding {
  const char* name;
  EncodeOptions options;
  int points;
};

OctreeOptions octree(Entropy entropy, int quality) {
  OctreeOptions options;
  options.entropy = entropy;
  options.depth = DepthRule::fixed(8);
  options.color_quality = options.normal_quality = quality;
  return options;
}

DracoOptions draco(DracoMethod method) {
  DracoOptions options;
  options.method = method;
  return options;
}

class HostileFrames : public testing::TestWithParam<Coding> {
 protected:
  static EncodedFrame encode() {
    PointCloud cloud;
    for (int i = 0; i < GetParam().points; ++i) {
      cloud.positions.push_back(glm::vec3(i * i % 7, i * 3 % 5, i % 2) / 300.0f + 0.5f);
      cloud.normals.push_back(glm::normalize(glm::vec3(i % 3 - 1, i % 2, 1)));
      cloud.colors.push_back(glm::u16vec3(i * 40 % 256, i * 90 % 256, 200) * std::uint16_t{257});
    }
    auto frame = encode_frame(cloud, Cube{}, GetParam().options);
    EXPECT_TRUE(frame) << frame.error().message;
    return std::move(*frame);
  }

  /// Calls `visit(part, begin)` for each part that the frame has: its bytes, which `visit` may
  /// change and which are restored afterwards, and the offset at which its chunk begins.
  template <class Visit>
  static void for_each_part(EncodedFrame& frame, Visit visit) {
    for (std::size_t layer = 0; layer < frame.layers.size(); ++layer) {
      for (const ChunkKind kind : {ChunkKind::geometry, ChunkKind::colors, ChunkKind::normals}) {
        Bytes& part = chunk_of(frame.layers[layer], kind);
        const Bytes whole = part;
        if (!part.empty()) visit(part, chunk_begin(layer, kind));
        part = whole;
      }
    }
  }
};
INSTANTIATE_TEST_SUITE_P(
    Codings, HostileFrames,
    testing::Values(Coding{"none", {octree(Entropy::none, 100)}, 12},
                    Coding{"zstd", {octree(Entropy::zstd, 100)}, 12},
                    Coding{"lossy", {octree(Entropy::none, 80)}, 12},
                    Coding{"context", {octree(Entropy::context, 80), false, false}, 8},
                    Coding{"kd_tree", {draco(DracoMethod::kd_tree)}, 3},
                    Coding{"sequential", {draco(DracoMethod::sequential)}, 3}),
    [](const auto& coding) { return coding.param.name; });

TEST_P(HostileFrames, are_decoded_from_memory_that_ends_exactly_where_they_end) {
  const EncodedFrame frame = encode();
  const auto decoded = decode_exactly(frame);
  ASSERT_TRUE(decoded) << decoded.error().message;
  EXPECT_EQ(decoded->cloud.size(), frame.coded_points);
  expect_sound(decoded);
}

TEST_P(HostileFrames, are_refused_if_truncated_at_any_byte) {
  EncodedFrame frame = encode();
  for_each_part(frame, [&](Bytes& part, std::size_t) {
    while (part.size() > 1) {
      part.pop_back();
      ASSERT_FALSE(decode_exactly(frame)) << part.size();
    }
  });
}

TEST_P(HostileFrames, are_refused_or_sound_if_truncated_behind_valid_checksums) {
  EncodedFrame frame = encode();
  for_each_part(frame, [&](Bytes& part, std::size_t begin) {
    while (part.size() > begin + kChunkHeaderSize) {
      part.pop_back();
      mend_chunk(part, begin);
      expect_sound(decode_exactly(frame));
    }
  });
}

TEST_P(HostileFrames, are_refused_if_any_bit_is_flipped) {
  EncodedFrame frame = encode();
  for_each_part(frame, [&](Bytes& part, std::size_t) {
    for (std::uint8_t& byte : part) {
      for (int bit = 0; bit < 8; ++bit) {
        byte = static_cast<std::uint8_t>(byte ^ 1 << bit);
        ASSERT_FALSE(decode_exactly(frame)) << &byte - part.data();
        byte = static_cast<std::uint8_t>(byte ^ 1 << bit);
      }
    }
  });
}

TEST_P(HostileFrames, are_refused_or_sound_if_any_bit_is_flipped_behind_valid_checksums) {
  EncodedFrame frame = encode();
  for_each_part(frame, [&](Bytes& part, std::size_t begin) {
    for (std::uint8_t& byte : part) {
      for (int bit = 0; bit < 8; ++bit) {
        const auto old = byte;
        byte = static_cast<std::uint8_t>(byte ^ 1 << bit);
        mend_chunk(part, begin);
        if (begin > 0) mend_frame_header(part);
        expect_sound(decode_exactly(frame));
        byte = old;
      }
    }
  });
}

}  // namespace
}  // namespace pointreel::hostile_frames_test
