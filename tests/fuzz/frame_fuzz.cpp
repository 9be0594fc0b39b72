// Makes valid frames of both codecs from points at the beginning of the input, changes their
// headers and payloads as the rest of the input says, and corrects the checksums.

#include <algorithm>
#include <cmath>

#include "pointreel/codec.h"
#include "pointreel/draco.h"
#include "pointreel/octree.h"
#include "tests/forge.h"
#include "tests/fuzz/target.h"

namespace pointreel::fuzz::frame {

const DecodeLimits kLimits{1u << 16, std::uint64_t{256} << 20};

/// Reads an input byte by byte, and zeros after its end.
class Input {
 public:
  explicit Input(ByteView bytes) : rest_(bytes) {}

  std::uint8_t byte() {
    if (rest_.empty()) return 0;
    const std::uint8_t first = rest_.front();
    rest_ = rest_.subspan(1);
    return first;
  }
  std::size_t word() {
    const std::size_t low = byte();
    return low | static_cast<std::size_t>(byte()) << 8;
  }

 private:
  ByteView rest_;
};

EncodeOptions options_of(Input& input) {
  const std::uint8_t choice = input.byte();
  const int parameter = input.byte();
  EncodeOptions options;
  options.colors = choice & 1;
  options.normals = choice & 2;
  if ((choice & 4) != 0) {
    DracoOptions draco;
    draco.position_bits = 1 + parameter % kMaxDepth;
    draco.compression_level = input.byte() % 11;
    draco.method = (choice & 8) != 0 ? DracoMethod::sequential : DracoMethod::kd_tree;
    options.codec = draco;
  } else {
    OctreeOptions octree;
    octree.entropy = static_cast<Entropy>(choice / 8 % 3);
    octree.depth = DepthRule::fixed(parameter % (kMaxDepth + 1));
    octree.color_quality = 1 + input.byte() % 100;
    octree.normal_quality = 1 + input.byte() % 100;
    if (choice >= 224) {
      octree.entropy = Entropy::context;
      octree.slabs = 1 + parameter % 4;
      octree.depth = DepthRule::fixed(8);  // a greater depth takes seconds on a busy machine
    }
    options.codec = octree;
  }
  return options;
}

/// A bent sheet with enough points for several slabs.
PointCloud sheet(Input& input) {
  PointCloud cloud;
  const int bend = input.byte(), twist = input.byte();
  for (int i = 0; i < 128; ++i) {
    for (int j = 0; j < 100; ++j) {
      const glm::vec3 cell((bend * i + twist * j) / 256 % 128, i, j);
      cloud.positions.push_back((cell + 0.5f) / 128.0f);
    }
  }
  return cloud;
}

PointCloud cloud_of(Input& input) {
  PointCloud cloud;
  const int points = input.byte();
  const auto part = [&] { return static_cast<float>(input.byte()) / 256.0f; };
  for (int i = 0; i < points; ++i) {
    const float x = part(), y = part(), z = part();
    cloud.positions.emplace_back(x, y, z);
    cloud.colors.push_back(glm::u16vec3(input.byte()) * std::uint16_t{257});
    const glm::vec3 normal(x - 0.5f, y - 0.5f, z - 0.5f);
    cloud.normals.push_back(x == 0.5f ? glm::vec3(0.0f) : glm::normalize(normal));
  }
  return cloud;
}

void change(EncodedFrame& frame, Input& input) {
  for (int changes = input.byte() % 6; changes > 0; --changes) {
    const std::uint8_t where = input.byte();
    const auto kind = static_cast<ChunkKind>(where % 3);
    const std::size_t layer = where / 3 % frame.layers.size();
    Bytes& part = chunk_of(frame.layers[layer], kind);
    const std::size_t at = input.word();
    const std::uint8_t value = input.byte();
    if (where >= 224) {
      part.resize(part.size() * value / 128, value);
    } else if (where >= 192 && !part.empty()) {
      // Change one of the first bytes, which describe the rest.
      part[at % std::min(part.size(), std::size_t{64})] ^= value;
    } else if (!part.empty()) {
      part[at % part.size()] ^= value;
    }
  }
  mend(frame);
}

}  // namespace pointreel::fuzz::frame

FUZZ_TARGET(frame) {
  Input rest(input);
  const EncodeOptions options = options_of(rest);
  const auto* octree = std::get_if<OctreeOptions>(&options.codec);
  const bool slabs = octree != nullptr && octree->slabs > 0;
  const PointCloud cloud = slabs ? sheet(rest) : cloud_of(rest);
  auto frame = encode_frame(cloud, Cube{}, options);
  require(frame.has_value());
  require(decode_frame(layer_views(frame->layers), kLimits).has_value());
  change(*frame, rest);
  const auto decoded = decode_frame(layer_views(frame->layers), kLimits);
  if (!decoded) return;
  const PointCloud& out = decoded->cloud;
  require(out.size() <= kLimits.max_points);
  require(out.colors.empty() || out.colors.size() == out.size());
  require(out.normals.empty() || out.normals.size() == out.size());
  require(!decoded->svo || decoded->svo->leaf_count() == out.size());
  for (const glm::vec3& p : out.positions) {
    for (int axis = 0; axis < 3; ++axis) {
      require(p[axis] >= 0.0f && p[axis] <= 1.00001 * decoded->cube.edge);
    }
  }
}
