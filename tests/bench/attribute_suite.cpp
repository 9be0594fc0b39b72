#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "codec/core/build.h"
#include "codec/distance/distance.h"
#include "codec/octree/attribute_coder.h"
#include "codec/octree/color_space.h"
#include "codec/octree/normal_space.h"
#include "codec/octree/octree_codec.h"
#include "codec/surface/normals.h"
#include "common/process/print.h"
#include "datasets_synthetic/motion.h"
#include "datasets_synthetic/voxelize.h"
#include "tests/bench/measure.h"
#include "tests/bench/suites.h"

namespace pointreel::bench {
namespace {

/// A tree with the values of its leaves.
struct Leaves {
  Svo svo;
  std::vector<Short4> values;
};

struct Coded {
  double bits = 0.0;  ///< per leaf
  Timing encode, decode;
  std::vector<Short4> values;
};

/// Codes the values alone, without the tree.
Coded code(const Leaves& leaves, AttributeKind kind, const CoefficientSteps& steps, int runs) {
  const Svo& svo = leaves.svo;
  std::vector<int> ends;
  for (int layer = 0; layer < layer_count(svo.depth); ++layer) {
    ends.push_back(last_level_of_layer(layer, svo.depth));
  }
  const FrameStructure structure(svo, ends);
  std::vector<Bytes> layers;
  Coded coded;
  coded.encode = measure(runs, [&] {
    TransformEncoder encoder(structure, kind, leaves.values);
    layers.clear();
    for (const int end : ends) {
      layers.push_back(
          encoder.encode_layer(layer_steps(steps, svo.leaf_count(), svo.node_count(end))));
    }
  });
  coded.decode = measure(runs, [&] {
    TransformDecoder decoder(structure, kind);
    for (std::size_t i = 0; i < ends.size(); ++i) (void)decoder.decode_layer(layers[i], ends[i]);
    const auto values = decoder.values(svo.depth);
    coded.values.assign(values.begin(), values.end());
  });
  for (const Bytes& layer : layers) coded.bits += 8.0 * static_cast<double>(layer.size());
  coded.bits /= svo.leaf_count();
  return coded;
}

/// The PSNR of luma, Cb and Cr of the decoded 8-bit colours in dB.
glm::dvec3 psnr(const std::vector<Short4>& source, const std::vector<Short4>& decoded) {
  glm::dvec3 sum(0.0);
  for (std::size_t i = 0; i < source.size(); ++i) {
    const Int4 d = load(source[i]) - ycbcr_from_rgb(color_from_value(decoded[i]));
    sum += glm::dvec3(d[0] * d[0], d[1] * d[1], d[2] * d[2]);
  }
  return color_psnr(sum / (static_cast<double>(source.size()) * kValuesPerStep * kValuesPerStep));
}

double mean_degrees(const std::vector<glm::vec3>& normals, const std::vector<glm::vec3>& truth) {
  double sum = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    sum +=
        std::atan2(glm::length(glm::cross(normals[i], truth[i])), glm::dot(normals[i], truth[i]));
  }
  return glm::degrees(sum / static_cast<double>(truth.size()));
}

/// The bits at a target PSNR, interpolated between two qualities; nothing if it is not between
/// them.
std::optional<double> bits_at(double target, double psnr0, double bits0, double psnr1,
                              double bits1) {
  if (!(psnr0 < target && target <= psnr1)) return std::nullopt;
  const double t = (target - psnr0) / (psnr1 - psnr0);
  return std::exp(std::log(bits0) * (1.0 - t) + std::log(bits1) * t);
}

void measure_colors(const SuiteOptions& options, const PointCloud& cloud, const Leaves& leaves,
                    int runs, nlohmann::json& rows, std::vector<Bar>& bars) {
  double last_luma = 0.0, last_bits = 0.0;
  for (const int quality : {29, 36, 43, 50, 57, 64, 71}) {
    const Coded coded = code(leaves, AttributeKind::colors, color_steps(quality), runs);
    const glm::dvec3 db = psnr(leaves.values, coded.values);
    print(
        "colours, quality {:>3} {:>8.3f} bits, luma {:.2f} Cb {:.2f} Cr {:.2f}, 6:1:1 {:.2f} dB, "
        "{:>7.2f} / {:.2f} ms\n",
        quality, coded.bits, db.x, db.y, db.z, yuv_psnr(db), coded.encode.median,
        coded.decode.median);
    rows.push_back({{"attribute", "colors"},
                    {"points", cloud.size()},
                    {"quality", quality},
                    {"bits_per_point", coded.bits},
                    {"psnr", {db.x, db.y, db.z}},
                    {"encode_ms", to_json(coded.encode)},
                    {"decode_ms", to_json(coded.decode)}});
    for (const auto& [target, limit] : {std::pair(37.0, 0.28), std::pair(41.0, 0.90)}) {
      const auto bits = bits_at(target, last_luma, last_bits, db.x, coded.bits);
      if (!bits || options.quick) continue;
      const std::string name = fmt::format("colours of a dense human at luma {} dB", target);
      // The time is proportional to the number of points.
      const double scale = 800'000.0 / static_cast<double>(cloud.size());
      bars.push_back({name, *bits, "bits per point", limit});
      bars.push_back({name + ", 800,000: encode", scale * coded.encode.median, "ms", 45.0});
      bars.push_back({name + ", 800,000: decode", scale * coded.decode.median, "ms", 40.0});
    }
    last_luma = db.x;
    last_bits = coded.bits;
  }
}

void measure_normals(const PointCloud& cloud, const Leaves& leaves, int runs,
                     nlohmann::json& rows) {
  const auto row = [&](const std::string& method, double bits, double degrees) {
    print("normals, {:<13} {:>6.3f} bits, mean error {:.2f} degrees\n", method, bits, degrees);
    rows.push_back({{"attribute", "normals"},
                    {"points", cloud.size()},
                    {"method", method},
                    {"bits_per_point", bits},
                    {"mean_degrees", degrees}});
  };
  for (const int quality : {29, 36, 43, 57, 71}) {
    const Coded coded = code(leaves, AttributeKind::normals, normal_steps(quality), runs);
    std::vector<glm::vec3> normals;
    for (const Short4& value : coded.values) normals.push_back(normal_from_value(value));
    row(fmt::format("quality {}", quality), coded.bits, mean_degrees(normals, cloud.normals));
  }
  PointCloud bare;
  bare.positions = cloud.positions;
  estimate_normals(bare);
  row("derived", 0.0, mean_degrees(bare.normals, cloud.normals));
}

}  // namespace

void run_attributes(const SuiteOptions& options, nlohmann::json& rows, std::vector<Bar>& bars) {
  const Body body = pose_body(find_motion("walk")->pose(0.3));
  const VoxelGrid grid = voxel_grid(bounds(body.surface), options.quick ? 8 : 10);
  const auto cloud = voxelize(body, grid);
  if (!cloud) {
    print_error("pointreel-bench", cloud.error().message);
    return;
  }
  print("Attributes of a human of {} voxels at {} bits, without the tree\n", cloud->size(),
        grid.bits);
  const Cube cube{cloud->origin - 0.5, std::ldexp(1.0, grid.bits)};
  const SortedPoints sorted = sort_points(*cloud, cube, grid.bits);
  Leaves leaves{build_svo(sorted, grid.bits), {}};
  // The voxels have the same order as the leaves.
  for (const glm::u16vec3& color : cloud->colors) leaves.values.push_back(value_from_color(color));
  const int runs = options.quick ? 3 : 7;
  measure_colors(options, *cloud, leaves, runs, rows, bars);
  leaves.values.clear();
  for (const glm::i16vec3& normal : mean_leaf_normals(leaves.svo, *cloud, sorted)) {
    leaves.values.push_back(value_from_normal(normal));
  }
  measure_normals(*cloud, leaves, runs, rows);
}

}  // namespace pointreel::bench
