#include "tests/bench/codec_rates.h"

#include <cmath>
#include <optional>
#include <thread>
#include <utility>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include "codec/core/lattice.h"
#include "codec/distance/distance.h"
#include "codec/draco/part_sizes.h"
#include "codec/files/cloud_file.h"
#include "common/base/try.h"
#include "common/process/print.h"
#include "pointreel/draco.h"
#include "tests/bench/measure.h"
#include "tests/bench/peak_memory.h"
#include "tests/bench/report/datasets.h"

namespace pointreel::bench {
namespace {

constexpr int kBits = 10;

/// A frame to encode on a grid of 2^kBits cells along each axis.
struct RateSource {
  std::string name;
  PointCloud cloud;
  Cube cube;
};

struct Setting {
  std::string codec, name;
  EncodeOptions options;
};

Setting octree(Entropy entropy, int colors = kDefaultColorQuality,
               int normals = kDefaultNormalQuality) {
  OctreeOptions options;
  options.entropy = entropy;
  options.depth = DepthRule::fixed(kBits);
  options.color_quality = colors;
  options.normal_quality = normals;
  options.normals_follow_noise = false;
  return {fmt::format("octree {}", name(entropy)),
          fmt::format("quality {}, normals {}", colors, normals),
          {options}};
}

Setting draco(DracoMethod method, int level) {
  DracoOptions options;
  options.position_bits = kBits;
  options.method = method;
  options.compression_level = level;
  return {method == DracoMethod::kd_tree ? "draco kd-tree" : "draco sequential",
          fmt::format("cl {}", level),
          {options}};
}

Setting without(Setting setting, bool normals, bool colors) {
  if (!normals) setting.options.normals = false;
  if (!colors) setting.options.colors = false;
  setting.name = colors ? "normals derived" : "positions";
  return setting;
}

std::vector<Setting> settings_of(bool quick) {
  std::vector<Setting> list;
  for (const Entropy entropy : {Entropy::none, Entropy::zstd, Entropy::context}) {
    list.push_back(without(octree(entropy), false, false));
    list.push_back(octree(entropy));
  }
  list.push_back(draco(DracoMethod::kd_tree, 7));
  if (quick) return list;
  list.push_back(without(octree(Entropy::context), false, true));
  for (const auto& [colors, normals] : {std::pair(20, 20), {35, 30}, {65, 60}, {80, 80}}) {
    list.push_back(octree(Entropy::context, colors, normals));
  }
  for (const Entropy entropy : {Entropy::none, Entropy::zstd}) {
    list.push_back(octree(entropy, kLosslessColorQuality, kBestNormalQuality));
  }
  list.push_back(without(draco(DracoMethod::kd_tree, 10), false, false));
  for (const int level : {0, 4, 10}) list.push_back(draco(DracoMethod::kd_tree, level));
  for (const int level : {0, 7, 10}) list.push_back(draco(DracoMethod::sequential, level));
  return list;
}

/// Whether a source takes so long that it is measured less often.
bool is_large(const RateSource& source) { return source.cloud.size() > 400'000; }

/// Milliseconds per frame when many frames are processed at once.
template <class Work>
double all_cores_ms(std::size_t frames, const Work& work) {
  const double begin = now_ms();
  tbb::parallel_for(std::size_t{0}, frames, [&](std::size_t) { work(); });
  return (now_ms() - begin) / static_cast<double>(frames);
}

/// Neither JSON nor the table can show infinity.
nlohmann::json finite_or_null(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json();
}
std::string decibels(double value) {
  return std::isfinite(value) ? fmt::format("{:.1f}", value) : "exact";
}

Result<nlohmann::json> measure_setting(const RateSource& source, const Setting& setting, int runs) {
  const auto encode = [&] { return encode_frame(source.cloud, source.cube, setting.options); };
  const EncodedFrame frame = TRY(encode());
  const auto layers = layer_views(frame.layers);
  const DecodedFrame decoded = TRY(decode_frame(layers));
  const CloudDistance error = TRY(cloud_distance(source.cloud, decoded.cloud));
  const auto parts = TRY(measure_part_sizes(frame, source.cloud, source.cube, setting.options));

  const Timing encoding = measure(runs, [&] { (void)encode(); });
  const Timing decoding = measure(runs, [&] { (void)decode_frame(layers); });
  const std::size_t threads = std::max(1u, std::thread::hardware_concurrency());
  const std::size_t frames = threads * (is_large(source) ? 1 : 2);
  const double encoding_all = all_cores_ms(frames, [&] { (void)encode(); });
  const double decoding_all = all_cores_ms(frames, [&] { (void)decode_frame(layers); });
  const double encoding_mib = peak_mib([&] { (void)encode(); });
  const double decoding_mib = peak_mib([&] { (void)decode_frame(layers); });

  const double n = static_cast<double>(source.cloud.size());
  const auto bits = [n](std::size_t bytes) { return 8.0 * static_cast<double>(bytes) / n; };
  const double cell = std::ldexp(source.cube.edge, -kBits);
  const double d1 = geometry_psnr(error.d1(), source.cube.edge - cell);
  const glm::dvec3 color = color_psnr(error.colors().value_or(ColorError(0.0)));
  const bool colored = error.colors().has_value();
  const double degrees = error.normals() ? glm::degrees(error.normals()->mean) : 0.0;
  const auto nanoseconds = [n](const Timing& timing) { return 1e6 * timing.median / n; };
  print(
      "{:<14} {:<16} {:<25} {:>7.3f} {:>7.3f} {:>7.3f} {:>6} {:>5.2f} {:>6} {:>6} {:>8.2f} "
      "{:>8.2f} {:>8.2f} {:>8.2f} {:>5.0f} {:>5.0f} {:>5.0f} {:>5.0f}\n",
      source.name, setting.codec, setting.name, bits(parts.geometry), bits(parts.colors),
      bits(parts.normals), decibels(d1), error.max() / cell, colored ? decibels(color.x) : "-",
      error.normals() ? fmt::format("{:.2f}", degrees) : "-", encoding.median, decoding.median,
      encoding_all, decoding_all, nanoseconds(encoding), nanoseconds(decoding), encoding_mib,
      decoding_mib);
  nlohmann::json row = {{"dataset", source.name},
                        {"codec", setting.codec},
                        {"setting", setting.name},
                        {"points", source.cloud.size()},
                        {"coded_points", frame.coded_points},
                        {"bits",
                         {{"geometry", bits(parts.geometry)},
                          {"colors", bits(parts.colors)},
                          {"normals", bits(parts.normals)},
                          {"all", bits(frame.size())}}},
                        {"d1_rms", std::sqrt(error.d1())},
                        {"d1_psnr", finite_or_null(d1)},
                        {"max", error.max()},
                        {"max_cells", error.max() / cell},
                        {"encode_ms", to_json(encoding)},
                        {"decode_ms", to_json(decoding)},
                        {"encode_ns_per_point", nanoseconds(encoding)},
                        {"decode_ns_per_point", nanoseconds(decoding)},
                        {"all_cores",
                         {{"threads", threads},
                          {"encode_ms_per_frame", encoding_all},
                          {"decode_ms_per_frame", decoding_all}}},
                        {"encode_mib", encoding_mib},
                        {"decode_mib", decoding_mib}};
  if (colored) {
    row["color_psnr"] = {{"y", finite_or_null(color.x)},
                         {"cb", finite_or_null(color.y)},
                         {"cr", finite_or_null(color.z)},
                         {"yuv", finite_or_null(yuv_psnr(color))}};
  }
  if (error.normals()) row["normal_degrees"] = degrees;
  return row;
}

/// A voxelised cloud is measured on its own voxels if 2^kBits of them reach from end to end.
Cube cube_for(const PointCloud& cloud) {
  const Box box = bounds(cloud);
  if (const std::optional<PointLattice> lattice = lattice_of(cloud)) {
    const VoxelCube voxels = lattice_cube(box, *lattice);
    if (voxels.depth <= kBits) {
      return {voxels.cube.origin, std::ldexp(voxels.cube.edge, kBits - voxels.depth)};
    }
  }
  return bounding_cube(box);
}

/// A frame of each scanned sequence, one of a dense sequence, and the clouds in the files.
Result<std::vector<RateSource>> rate_sources(const SuiteOptions& options) {
  std::vector<RateSource> sources;
  std::vector<Dataset> datasets = scanned_datasets();
  if (options.quick) datasets.resize(1);
  if (!options.quick) datasets.push_back(dense_dataset());
  for (const Dataset& dataset : datasets) {
    PointCloud cloud =
        std::move(TRY(make_clouds(dataset, spread(dataset.motion->poses, 1))).front());
    const Box box = bounds(cloud);
    const Cube cube = dataset.options.voxels ? voxel_cube(box, 1.0).cube : bounding_cube(box);
    sources.push_back({dataset.name, std::move(cloud), cube});
  }
  for (const std::filesystem::path& file : options.files) {
    LoadedCloud loaded = TRY(read_cloud_file(file));
    if (loaded.cloud.empty()) return fail(file.string() + ": has no points to measure");
    const Cube cube = cube_for(loaded.cloud);
    sources.push_back({file.filename().string(), std::move(loaded.cloud), cube});
  }
  return sources;
}

}  // namespace

nlohmann::json run_rates(const SuiteOptions& options) {
  const auto sources = rate_sources(options);
  if (!sources) {
    print_error("pointreel-bench", sources.error().message);
    return nlohmann::json::array();
  }
  print(
      "\nCodecs at {} bits per coordinate: bits per point, D1 PSNR, largest error in cells, luma "
      "PSNR, mean angle of\nnormals; median ms on one thread, ms per frame with frames on all "
      "cores, ns per point, and MiB\n",
      kBits);
  print(
      "{:<14} {:<16} {:<25} {:>7} {:>7} {:>7} {:>6} {:>5} {:>6} {:>6} {:>8} {:>8} {:>8} {:>8} "
      "{:>5} {:>5} {:>5} {:>5}\n",
      "dataset", "codec", "setting", "geom", "colors", "normals", "D1 dB", "max", "Y dB", "deg",
      "enc ms", "dec ms", "enc all", "dec all", "ns", "ns", "MiB", "MiB");
  auto rows = nlohmann::json::array();
  for (const RateSource& source : *sources) {
    const int runs = options.quick || is_large(source) ? 2 : 5;
    for (const Setting& setting : settings_of(options.quick)) {
      auto row = measure_setting(source, setting, runs);
      if (!row) {
        print_error("pointreel-bench", fmt::format("{}, {} {}: {}", source.name, setting.codec,
                                                   setting.name, row.error().message));
        continue;
      }
      rows.push_back(std::move(*row));
    }
  }
  return rows;
}

}  // namespace pointreel::bench
