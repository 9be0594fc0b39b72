#include <cmath>

#include <fmt/format.h>

#include "codec/cloud_file.h"
#include "codec/codec.h"
#include "codec/octree/octree_codec.h"
#include "common/surface/distance.h"
#include "tests/bench/clouds.h"
#include "tests/bench/grid_suite.h"
#include "tests/bench/measure.h"
#include "tests/bench/suites.h"

namespace pointreel::bench {
namespace {

struct Setting {
  std::string name;
  EncodeOptions options;
};

std::vector<Setting> settings(bool attributes) {
  std::vector<Setting> list;
  for (const Entropy entropy : {Entropy::none, Entropy::zstd, Entropy::context}) {
    list.push_back({fmt::format("octree {} 10", name(entropy)),
                    {OctreeOptions{entropy, DepthRule::fixed(10)}, attributes, attributes}});
  }
  for (const int bits : {10, 11}) {
    DracoOptions draco;
    draco.position_bits = bits;
    list.push_back({fmt::format("draco kd {}", bits), {draco, attributes, attributes}});
  }
  return list;
}

/// One row of the table: speed and size beside the error that they buy.
nlohmann::json measure_setting(const std::string& dataset, const PointCloud& cloud,
                               const Setting& setting, int runs, std::vector<Bar>* bars) {
  const Cube cube = bounding_cube(bounds(cloud));
  const auto frame = encode_frame(cloud, cube, setting.options);
  if (!frame) return {{"setting", setting.name}, {"error", frame.error().message}};
  const auto layers = layer_views(frame->layers);
  const auto decoded = decode_frame(layers);
  if (!decoded) return {{"setting", setting.name}, {"error", decoded.error().message}};

  const Timing encode = measure(runs, [&] { (void)encode_frame(cloud, cube, setting.options); });
  const Timing decode = measure(runs, [&] { (void)decode_frame(layers); });
  const auto error = cloud_distance(cloud, decoded->cloud);
  if (!error) return {{"setting", setting.name}, {"error", error.error().message}};
  const auto parts = measure_parts(*frame, cloud, cube, setting.options);
  const double n = static_cast<double>(cloud.size());
  const double bits = 8.0 * static_cast<double>(frame->size()) / n;
  const double geometry_bits = parts ? 8.0 * static_cast<double>(parts->geometry) / n : 0.0;
  const double d1 = std::sqrt(error->d1());
  fmt::print("{:<22} {:<15} {:>9} {:>8.3f} {:>8.3f} {:>9.2f} {:>9.2f} {:>10.3g} {:>10.3g}\n",
             dataset, setting.name, frame->coded_points, geometry_bits, bits, encode.median,
             decode.median, d1 / cube.edge, error->max() / cube.edge);
  nlohmann::json row = {{"dataset", dataset},
                        {"setting", setting.name},
                        {"points", cloud.size()},
                        {"coded_points", frame->coded_points},
                        {"bits_per_point", bits},
                        {"geometry_bits_per_point", geometry_bits},
                        {"encode_ms", to_json(encode)},
                        {"decode_ms", to_json(decode)},
                        {"d1_rms", d1},
                        {"max_distance", error->max()},
                        {"cube_edge", cube.edge}};
  if (setting.options.id() == Codec::octree) {
    const Timing tree = measure(runs, [&] { (void)decode_octree_tree(layers, {}); });
    row["decode_to_svo_ms"] = to_json(tree);
    if (bars != nullptr) {
      const auto entropy = std::get<OctreeOptions>(setting.options.codec).entropy;
      if (entropy == Entropy::none) {
        bars->push_back({"octree none, 88,315 points, depth 10: encode", encode.median, "ms", 3.0});
        bars->push_back({"octree none, 88,315 points: decode to an SVO", tree.median, "ms", 1.0});
      }
    }
  }
  return row;
}

}  // namespace

nlohmann::json run_codec(const SuiteOptions& options) {
  const int runs = options.quick ? 5 : 15;
  fmt::print("Codecs, one thread: medians of {} runs; errors as fractions of the cube's edge\n",
             runs);
  fmt::print("{:<22} {:<15} {:>9} {:>8} {:>8} {:>9} {:>9} {:>10} {:>10}\n", "dataset", "setting",
             "points", "bits/pt", "with all", "encode ms", "decode ms", "D1 rms", "max");
  auto rows = nlohmann::json::array();
  std::vector<Bar> bars;
  const PointCloud scan = scan_like_cloud(88'315);
  for (const Setting& setting : settings(false)) {
    rows.push_back(measure_setting("scan-like, positions", scan, setting, runs, &bars));
  }
  for (const Setting& setting : settings(true)) {
    rows.push_back(measure_setting("scan-like", scan, setting, runs, nullptr));
  }
  for (const std::filesystem::path& file : options.files) {
    const auto loaded = read_cloud_file(file);
    if (!loaded) {
      fmt::print(stderr, "pointreel-bench: {}\n", loaded.error().message);
      continue;
    }
    for (const Setting& setting : settings(true)) {
      rows.push_back(
          measure_setting(file.filename().string(), loaded->cloud, setting, runs, nullptr));
    }
  }
  const auto grids = run_grids(options, bars);
  auto attributes = nlohmann::json::array();
  run_attributes(options, attributes, bars);
  print(bars);
  return {{"rows", rows}, {"grids", grids}, {"attributes", attributes}, {"bars", to_json(bars)}};
}

}  // namespace pointreel::bench
