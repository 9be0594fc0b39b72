#include "tests/bench/report/rates.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "codec/core/build.h"
#include "codec/distance/distance.h"
#include "codec/draco/part_sizes.h"
#include "codec/octree/octree_codec.h"
#include "common/base/try.h"
#include "pointreel/chunks.h"
#include "pointreel/codec.h"
#include "pointreel/draco.h"
#include "pointreel/octree.h"
#include "tests/bench/measure.h"

namespace pointreel::bench {
namespace {

using nlohmann::json;

/// A coded cloud counts as near to the truth as its source if its mean distance is at most this
/// many times that of the source.
constexpr double kAsGood = 1.05;
constexpr double kTreeDelta = 0.05;

/// A pose to encode, and the references for its errors.
struct Source {
  int pose;
  PointCloud cloud;
  Cube cube;
  double peak;    ///< of PSNR, in the units of the cloud
  double metres;  ///< the length of a unit of the cloud
};

struct Sums {
  std::size_t poses = 0;
  double points = 0.0, coded = 0.0;
  double geometry = 0.0, colors = 0.0, normals = 0.0;  ///< bytes
  double d1 = 0.0, d2 = 0.0, max = 0.0, max_cells = 0.0;
  double d1_share = 0.0, d2_share = 0.0;  ///< relative to the square of the peak, for PSNR
  ColorError color{0.0};
  double normal_mean = 0.0, normal_95 = 0.0;
  DistanceSummary truth;
  std::vector<double> encode, decode, tree;  ///< ms
};

void add(DistanceSummary& sum, const DistanceSummary& one) {
  sum.mean += one.mean;
  sum.percentile_95 += one.percentile_95;
  sum.percentile_999 += one.percentile_999;
  sum.max = std::max(sum.max, one.max);
}

json to_json(const DistanceSummary& sum, double count) {
  return {{"mean", sum.mean / count},
          {"p95", sum.percentile_95 / count},
          {"p999", sum.percentile_999 / count},
          {"max", sum.max}};
}

/// JSON has no infinity.
json finite_or_null(double value) { return std::isfinite(value) ? json(value) : json(); }

Source prepare(const Dataset& dataset, int pose, PointCloud cloud) {
  Source source;
  source.pose = pose;
  source.cloud = std::move(cloud);
  const Box box = bounds(source.cloud);
  source.cube = dataset.options.voxels ? voxel_cube(box, 1.0).cube : bounding_cube(box);
  const double cells = std::exp2(dataset.peak_bits);
  const double cell = dataset.options.voxels ? 1.0 : source.cube.edge / cells;
  source.peak = (cells - 1.0) * cell;
  source.metres = dataset.options.voxels ? dataset.options.voxels->voxel : 1.0;
  return source;
}

Result<void> measure(const Source& source, const Dataset& dataset, const Setting& setting, int runs,
                     Sums& sums) {
  const auto encode = [&] { return encode_frame(source.cloud, source.cube, setting.options); };
  const EncodedFrame frame = TRY(encode());
  const std::vector<Chunks<ByteView>> layers = layer_views(frame.layers);
  const DecodedFrame decoded = TRY(decode_frame(layers));
  const auto parts = TRY(measure_part_sizes(frame, source.cloud, source.cube, setting.options));
  const CloudDistance error = TRY(cloud_distance(source.cloud, decoded.cloud));

  ++sums.poses;
  sums.points += static_cast<double>(source.cloud.size());
  sums.coded += static_cast<double>(frame.coded_points);
  sums.geometry += static_cast<double>(parts.geometry);
  sums.colors += static_cast<double>(parts.colors);
  sums.normals += static_cast<double>(parts.normals);
  const double square = source.metres * source.metres;
  const double peak_square = source.peak * source.peak;
  const double d2 = error.d2().value_or(std::numeric_limits<double>::quiet_NaN());
  sums.d1 += error.d1() * square;
  sums.d2 += d2 * square;
  sums.d1_share += error.d1() / peak_square;
  sums.d2_share += d2 / peak_square;
  sums.max = std::max(sums.max, error.max() * source.metres);
  sums.max_cells =
      std::max(sums.max_cells, error.max() * std::exp2(setting.bits) / source.cube.edge);
  sums.color += error.colors().value_or(ColorError(0.0));
  const AngleError angles = error.normals().value_or(AngleError{});
  sums.normal_mean += angles.mean;
  sums.normal_95 += angles.percentile_95;
  add(sums.truth, TRY(distance_to_truth(dataset, source.pose, decoded.cloud)));

  const auto time = [runs](std::vector<double>& to, const auto& work) {
    const std::vector<double> times = time_runs(runs, work);
    to.insert(to.end(), times.begin(), times.end());
  };
  time(sums.encode, [&] { (void)encode(); });
  time(sums.decode, [&] { (void)decode_frame(layers); });
  time(sums.tree, [&] {
    if (setting.options.id() == Codec::octree) {
      (void)decode_octree_tree(layers, {});
    } else if (const auto points = decode_frame(layers)) {
      const auto sorted =
          sort_to_depth(points->cloud, points->cube, DepthRule::by_delta(kTreeDelta));
      if (sorted) (void)build_svo(sorted->sorted, sorted->depth);
    }
  });
  return {};
}

json to_json(const Setting& setting, const Sums& sums) {
  const double n = static_cast<double>(sums.poses);
  const auto bits = [&](double bytes) { return 8.0 * bytes / sums.points; };
  const glm::dvec3 color = color_psnr(sums.color / n);
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  return {{"codec", setting.codec},
          {"setting", setting.name},
          {"coordinate_bits", setting.bits},
          {"on_curve", setting.on_curve},
          {"coded_points", sums.coded / n},
          {"bits",
           {{"geometry", bits(sums.geometry)},
            {"colors", bits(sums.colors)},
            {"normals", bits(sums.normals)},
            {"all", bits(sums.geometry + sums.colors + sums.normals)}}},
          {"d1_rms", std::sqrt(sums.d1 / n)},
          {"d2_rms", std::sqrt(sums.d2 / n)},
          {"d1_psnr", finite_or_null(geometry_psnr(sums.d1_share / n, 1.0))},
          {"d2_psnr", finite_or_null(geometry_psnr(sums.d2_share / n, 1.0))},
          {"max", sums.max},
          {"max_cells", sums.max_cells},
          {"truth", to_json(sums.truth, n)},
          {"color_psnr",
           {{"y", finite_or_null(color.x)},
            {"cb", finite_or_null(color.y)},
            {"cr", finite_or_null(color.z)},
            {"yuv", finite_or_null(yuv_psnr(color))}}},
          {"normal_degrees",
           {{"mean", sums.normal_mean / n * kDegrees}, {"p95", sums.normal_95 / n * kDegrees}}},
          {"encode_ms", bench::to_json(summarise(sums.encode))},
          {"decode_ms", bench::to_json(summarise(sums.decode))},
          {"svo_ms", bench::to_json(summarise(sums.tree))}};
}

/// For each codec, the coarsest setting that is as near to the truth as the source.
json noise_ends(const json& rows, double source_mean) {
  json ends = json::array();
  std::map<std::string, json> best;
  for (const json& row : rows) {
    if (!row["on_curve"].get<bool>()) continue;
    const double mean = row["truth"]["mean"].get<double>();
    if (mean > kAsGood * source_mean) continue;
    const json& old = best[row["codec"].get<std::string>()];
    if (!old.is_null() && old["coordinate_bits"] <= row["coordinate_bits"]) continue;
    best[row["codec"].get<std::string>()] = row;
  }
  for (const auto& [codec, row] : best) {
    ends.push_back({{"codec", codec}, {"setting", row["setting"]}, {"mean", row["truth"]["mean"]}});
  }
  return ends;
}

}  // namespace

Result<json> measure_rates(const Dataset& dataset, const std::vector<int>& poses,
                           const std::vector<Setting>& settings, int runs,
                           const std::function<void()>& done) {
  std::vector<Sums> sums(settings.size());
  DistanceSummary truth;
  double points = 0.0, edge = 0.0;
  for (const int pose : poses) {
    std::vector<PointCloud> clouds = TRY(make_clouds(dataset, {pose}));
    const Source source = prepare(dataset, pose, std::move(clouds.front()));
    add(truth, TRY(distance_to_truth(dataset, pose, source.cloud)));
    points += static_cast<double>(source.cloud.size());
    edge += source.cube.edge * source.metres;
    for (std::size_t i = 0; i < settings.size(); ++i) {
      const Result<void> measured = measure(source, dataset, settings[i], runs, sums[i]);
      if (!measured) {
        return fail_at(fmt::format("{}, pose {}, {} {}", dataset.name, pose, settings[i].codec,
                                   settings[i].name),
                       measured.error());
      }
      done();
    }
  }
  const double n = static_cast<double>(poses.size());
  json rows = json::array();
  for (std::size_t i = 0; i < settings.size(); ++i) rows.push_back(to_json(settings[i], sums[i]));
  return json{{"dataset", dataset.name},
              {"poses", poses.size()},
              {"points", points / n},
              {"edge", edge / n},
              {"peak_bits", dataset.peak_bits},
              {"truth", to_json(truth, n)},
              {"noise_ends", noise_ends(rows, truth.mean / n)},
              {"rows", rows}};
}

}  // namespace pointreel::bench
