#include "tests/golden/videos.h"

#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "codec/video/video_decoder.h"
#include "codec/video_encode/video_encoder.h"
#include "common/base/try.h"
#include "common/file_system/write_file.h"
#include "tests/forge.h"
#include "tests/golden/hash.h"
#include "tests/golden/streams.h"
#include "tests/pointers_to.h"

namespace pointreel::golden {
namespace {

constexpr int kSide = 64;
const glm::dvec3 kCubeCorner(100.0, -2.0, 0.5);
constexpr double kPitch = 0.25;

/// The voxels of a bowl that moves along x: two sheets behind each other, with stripes.
PointCloud bowl(int frame, bool colors) {
  PointCloud cloud;
  cloud.origin = kCubeCorner;
  const glm::dvec3 center(30.0 + frame, 40.0, 32.0);
  for (int z = 0; z < kSide; ++z) {
    for (int y = 0; y < 44; ++y) {
      for (int x = 0; x < kSide; ++x) {
        const glm::dvec3 place(x + 0.5, y + 0.5, z + 0.5), away = place - center;
        const double length = glm::length(away);
        const bool outer = std::abs(length - 24.0) < 0.5, inner = std::abs(length - 16.0) < 0.5;
        if (!outer && !inner) continue;
        cloud.positions.emplace_back(kPitch * place);
        cloud.normals.emplace_back(away / (outer ? length : -length));
        if (colors) cloud.colors.emplace_back(x / 4 % 2 * 50000, y * 1400, outer ? 9000 : 60000);
      }
    }
  }
  return cloud;
}

/// Adds points above the bowl, each too far from all others to be shown by a picture.
void add_lone_points(PointCloud& cloud) {
  for (int z = 4; z < kSide; z += 8) {
    for (int x = 4; x < kSide; x += 8) {
      cloud.positions.emplace_back(kPitch *
                                   glm::dvec3(x + 0.5, 56.5 + (x + z) / 8 % 2 * 4, z + 0.5));
      cloud.normals.emplace_back(0.0f, 1.0f, 0.0f);
      cloud.colors.emplace_back(x * 1000, 30000, z * 1000);
    }
  }
}

Result<EncodedFrame> bowls(int frames, bool colors, bool lone_points = false) {
  VideoOptions options;
  options.pitch = kPitch;
  options.side = kSide;
  options.preset = 8;
  std::vector<PointCloud> clouds;
  for (int i = 0; i < frames; ++i) {
    clouds.push_back(bowl(i, colors));
    if (lone_points) add_lone_points(clouds.back());
  }
  EncodedFrame group;
  group.layers = TRY(encode_video_group(pointers_to(clouds), kCubeCorner, options));
  return group;
}

using Groups = std::map<std::string, EncodedFrame>;

Groups damaged(const EncodedFrame& good) {
  Groups bad;
  auto& missing = bad["bad_frame_missing"] = good;
  missing.layers.erase(missing.layers.begin() + 1);
  auto& begun = bad["bad_first_missing"] = good;
  begun.layers.erase(begun.layers.begin());
  auto& geometry = bad["bad_geometry_cut"] = good;
  geometry.layers[1].geometry.resize(geometry.layers[1].geometry.size() / 2);
  auto& colors = bad["bad_colors_cut"] = good;
  colors.layers[0].colors.resize(colors.layers[0].colors.size() / 2);
  auto& magic = bad["bad_magic"] = good;
  magic.layers[0].geometry[0] ^= 1;
  auto& none = bad["bad_nothing"] = good;
  none.layers[0].geometry.clear();
  // Places in the header of the group, which begins behind the chunk's header and four sizes.
  const auto forged = [&](const char* name, std::size_t first, std::size_t last,
                          std::uint8_t value) {
    Bytes& chunk = (bad[name] = good).layers[0].geometry;
    for (std::size_t i = first; i <= last; ++i) chunk[36 + i] = value;
    mend_chunk(chunk, 0);
  };
  forged("bad_flag_of_colors", 1, 1, 2);
  forged("bad_pictures_empty", 36, 39, 0);
  return bad;
}

}  // namespace

nlohmann::json video_outcome(const EncodedFrame& group) {
  nlohmann::json frames = nlohmann::json::array();
  VideoDecoder decoder;
  for (const Chunks<ByteView>& chunks : layer_views(group.layers)) {
    const auto decoded = [&]() -> Result<PointCloud> {
      return points_of(TRY(decoder.next(chunks)));
    }();
    if (!decoded) {
      frames.push_back({{"error", name(decoded.error().code)}});
      break;
    }
    nlohmann::json frame = {{"points", decoded->size()}, {"positions", hash(decoded->positions)}};
    if (decoded->has_colors()) frame["colors"] = hash(decoded->colors);
    frame["normals"] = hash(decoded->normals);
    frames.push_back(std::move(frame));
  }
  return frames;
}

Result<void> write_videos(const std::filesystem::path& folder) {
  Groups groups = {{"bowl", TRY(bowls(4, true))},
                   {"bowl_with_leftovers", TRY(bowls(2, true, true))},
                   {"bowl_without_colors", TRY(bowls(2, false))}};
  groups["odd_colors_left_out"] = groups["bowl"];
  groups["odd_colors_left_out"].layers[1].colors.clear();
  groups.merge(damaged(groups["bowl"]));
  nlohmann::json outcomes;
  for (const auto& [name, group] : groups) {
    outcomes[name] = video_outcome(group);
    TRY(write_file(folder / (name + ".group"), file_of(group)));
  }
  return write_file(folder / "outcomes.json", outcomes.dump(1) + "\n");
}

}  // namespace pointreel::golden
