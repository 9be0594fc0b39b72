#include "tests/bench/grid_suite.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <tbb/task_arena.h>
#include <time.h>

#include "codec/core/lattice.h"
#include "codec/core/morton.h"
#include "codec/files/cloud_file.h"
#include "codec/octree/octree_codec.h"
#include "common/base/try.h"
#include "common/process/print.h"
#include "common/threads/tbb_executor.h"
#include "datasets_synthetic/body.h"
#include "datasets_synthetic/motion.h"
#include "datasets_synthetic/voxelize.h"
#include "pointreel/codec.h"
#include "pointreel/draco.h"

namespace pointreel::bench {
namespace {

constexpr int kFinestBits = 12;

/// Points at the centres of cells of edge 1, in a cube with 2^bits cells along each axis.
struct GriddedCloud {
  std::string name;
  PointCloud cloud;
  int bits = 10;

  Cube cube() const { return {glm::dvec3(0.0), std::ldexp(1.0, bits)}; }
};

/// The bits of the grid on which a voxelised cloud lies, if that is not finer than the grids here.
std::optional<int> own_bits(const PointCloud& cloud) {
  const std::optional<PointLattice> lattice = lattice_of(cloud);
  if (!lattice) return std::nullopt;
  const int bits = lattice_cube(bounds(cloud), *lattice).depth;
  return bits >= 1 && bits <= kFinestBits ? std::optional(bits) : std::nullopt;
}

/// Moves the points to the cells of a grid: the cloud's own if it has as many bits, otherwise one
/// that reaches from end to end of the cloud.
GriddedCloud gridded(std::string name, const PointCloud& cloud, int bits) {
  const Box box = bounds(cloud);
  const glm::dvec3 extent = box.max - box.min;
  const double edge = std::max({extent.x, extent.y, extent.z, 1e-300});
  const double cells =
      own_bits(cloud) == bits ? edge / lattice_of(cloud)->step : std::ldexp(1.0, bits) - 1.0;
  GriddedCloud out{std::move(name), {}, bits};
  std::vector<std::uint64_t> keys;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::dvec3 cell = glm::floor((cloud.world(i) - box.min) * (cells / edge) + 0.5);
    keys.push_back(morton_encode(glm::uvec3(cell)));
  }
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  for (const std::uint64_t key : keys) {
    out.cloud.positions.push_back(glm::vec3(morton_decode(key)) + 0.5f);
  }
  return out;
}

/// The limits of a well-known cloud, which is recognised by the name of its file.
struct GridLimits {
  const char* file;
  int bits;
  double bits_per_voxel, encode_ms, decode_ms;
};
constexpr GridLimits kGridLimits[] = {{"Guanyin.ply", 10, 6.50, 18, 24},
                                      {"Guanyin.ply", 12, 12.4, 60, 70},
                                      {"0000.ply", 10, 6.55, 7, 9}};

struct Figures {
  double bits_per_voxel = 0.0;
  Timing encode, decode;
};

Result<Figures> measure_coding(const GriddedCloud& data, const EncodeOptions& options, int runs) {
  const EncodedFrame frame = TRY(encode_frame(data.cloud, data.cube(), options));
  const auto layers = layer_views(frame.layers);
  const DecodedFrame decoded = TRY(decode_frame(layers));
  if (decoded.cloud.size() != data.cloud.size()) return fail("points were lost");
  Figures figures;
  figures.bits_per_voxel =
      8.0 * static_cast<double>(frame.size()) / static_cast<double>(data.cloud.size());
  figures.encode = measure(runs, [&] { (void)encode_frame(data.cloud, data.cube(), options); });
  // An octree frame counts as decoded when its tree is ready, because the tree is drawn.
  figures.decode = options.id() == Codec::octree
                       ? measure(runs, [&] { (void)decode_octree_tree(layers, {}); })
                       : measure(runs, [&] { (void)decode_frame(layers); });
  return figures;
}

nlohmann::json run_grid(const GriddedCloud& data, int runs, std::vector<Bar>& bars, bool dense) {
  auto rows = nlohmann::json::array();
  DracoOptions draco;
  draco.position_bits = data.bits;
  draco.compression_level = 10;
  std::vector<std::pair<std::string, EncodeOptions>> settings = {
      {"draco kd, cl 10", {draco, false, false}}};
  for (const Entropy entropy : {Entropy::none, Entropy::zstd, Entropy::context}) {
    settings.push_back({fmt::format("octree {}", name(entropy)),
                        {OctreeOptions{entropy, DepthRule::fixed(data.bits)}, false, false}});
  }
  std::optional<Figures> peer;
  Figures best;
  for (const auto& [name, options] : settings) {
    const auto figures = measure_coding(data, options, runs);
    if (!figures) {
      print_error("pointreel-bench",
                  fmt::format("{}, {}: {}", data.name, name, figures.error().message));
      continue;
    }
    if (!peer) peer = *figures;
    best = *figures;
    print("{:<22} {:>4} {:<16} {:>9} {:>9.4f} {:>9.2f} {:>9.2f} {:>8.3f} {:>7.3f} {:>7.3f}\n",
          data.name, data.bits, name, data.cloud.size(), figures->bits_per_voxel,
          figures->encode.median, figures->decode.median,
          figures->bits_per_voxel / peer->bits_per_voxel,
          figures->encode.median / peer->encode.median,
          figures->decode.median / peer->decode.median);
    rows.push_back({{"dataset", data.name},
                    {"grid_bits", data.bits},
                    {"setting", name},
                    {"voxels", data.cloud.size()},
                    {"bits_per_voxel", figures->bits_per_voxel},
                    {"encode_ms", to_json(figures->encode)},
                    {"decode_ms", to_json(figures->decode)}});
  }
  const auto bar = [&](const char* figure, double value, const char* unit, double limit) {
    bars.push_back({fmt::format("context, {} at {} bits: {}", data.name, data.bits, figure), value,
                    unit, limit});
  };
  if (dense && peer) {
    bar("size / Draco's", best.bits_per_voxel / peer->bits_per_voxel, "x", 0.16);
    bar("encode time / Draco's", best.encode.median / peer->encode.median, "x", 0.13);
    bar("decode time / Draco's", best.decode.median / peer->decode.median, "x", 0.42);
  }
  for (const GridLimits& limits : kGridLimits) {
    if (limits.file != data.name || limits.bits != data.bits) continue;
    bar("bits per voxel", best.bits_per_voxel, "bits", limits.bits_per_voxel);
    bar("encode", best.encode.median, "ms", limits.encode_ms);
    bar("decode to an SVO", best.decode.median, "ms", limits.decode_ms);
  }
  return rows;
}

/// The processor time that this thread has used, in milliseconds.
double cpu_ms() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

/// Measures the time that work would take with enough threads, no matter what else the machine
/// does: the processor time of one thread, counting only the longest of those jobs that could run
/// at the same time.
class CriticalPath {
 public:
  Executor executor() {
    return [this](int count, const std::function<void(int)>& body) {
      double sum = 0.0, most = 0.0;
      for (int job = 0; job < count; ++job) {
        const double begin = cpu_ms();
        body(job);
        const double ms = cpu_ms() - begin;
        sum += ms;
        most = std::max(most, ms);
      }
      hidden_ += sum - most;
    };
  }

  template <class Work>
  double measure(const Work& work) {
    hidden_ = 0.0;
    const double begin = cpu_ms();
    work();
    return cpu_ms() - begin - hidden_;
  }

 private:
  double hidden_ = 0.0;
};

/// Compares two slabs on two threads with one slab on one thread. The repetitions of all variants
/// take turns, so that a change of the machine's load affects all of them.
nlohmann::json run_slabs(const GriddedCloud& data, int runs, std::vector<Bar>& bars) {
  OctreeOptions octree{Entropy::context, DepthRule::fixed(data.bits)};
  octree.slabs = 1;
  const EncodeOptions one{octree, false, false};
  octree.slabs = 2;
  const EncodeOptions two{octree, false, false, tbb_executor()};
  const auto whole = encode_frame(data.cloud, data.cube(), one);
  const auto parted = encode_frame(data.cloud, data.cube(), two);
  if (!whole || !parted) {
    print_error("pointreel-bench", (whole ? parted : whole).error().message);
    return nullptr;
  }
  const double size = static_cast<double>(parted->size()) / static_cast<double>(whole->size());

  CriticalPath path;
  DecodeLimits on_threads, on_path;
  on_threads.executor = tbb_executor();
  on_path.executor = path.executor();
  EncodeOptions two_on_path = two;
  two_on_path.executor = path.executor();
  const auto encode = [&](const EncodeOptions& options) {
    (void)encode_frame(data.cloud, data.cube(), options);
  };
  const auto decode = [](const EncodedFrame& frame, const DecodeLimits& limits) {
    (void)decode_octree_tree(layer_views(frame.layers), limits);
  };
  const auto wall_ms = [](const auto& work) {
    const double begin = now_ms();
    work();
    return now_ms() - begin;
  };
  std::vector<double> encode_ms, decode_ms, encode_ratio, decode_ratio, encode_path, decode_path;
  tbb::task_arena arena(2);
  arena.execute([&] {
    for (int run = -1; run < runs; ++run) {
      const double encode_one = wall_ms([&] { encode(one); });
      const double encode_two = wall_ms([&] { encode(two); });
      const double decode_one = wall_ms([&] { decode(*whole, {}); });
      const double decode_two = wall_ms([&] { decode(*parted, on_threads); });
      const double encode_cpu = path.measure([&] { encode(one); });
      const double encode_critical = path.measure([&] { encode(two_on_path); });
      const double decode_cpu = path.measure([&] { decode(*whole, {}); });
      const double decode_critical = path.measure([&] { decode(*parted, on_path); });
      if (run < 0) continue;  // the first run does not count
      encode_ms.push_back(encode_two);
      decode_ms.push_back(decode_two);
      encode_ratio.push_back(encode_two / encode_one);
      decode_ratio.push_back(decode_two / decode_one);
      encode_path.push_back(encode_critical / encode_cpu);
      decode_path.push_back(decode_critical / decode_cpu);
    }
  });
  const Timing encoding = summarise(encode_ms), decoding = summarise(decode_ms);
  const Timing encode_by = summarise(encode_ratio), decode_by = summarise(decode_ratio);
  const Timing encode_critical = summarise(encode_path), decode_critical = summarise(decode_path);
  const double bits =
      8.0 * static_cast<double>(parted->size()) / static_cast<double>(data.cloud.size());
  print("{:<22} {:>4} {:<16} {:>9} {:>9.4f} {:>9.2f} {:>9.2f} {:>8.3f} {:>7.3f} {:>7.3f}\n",
        data.name, data.bits, "context, 2 slabs", data.cloud.size(), bits, encoding.median,
        decoding.median, size, encode_by.median, decode_by.median);
  print(
      "  (2 threads; ratios to one slab on one thread. Critical path: encode {:.3f}, decode "
      "{:.3f})\n",
      encode_critical.median, decode_critical.median);
  const auto bar = [&](const char* figure, double value, double limit) {
    bars.push_back(
        {fmt::format("two threads / one thread, {}: {}", data.name, figure), value, "x", limit});
  };
  bar("size", size, 1.015);
  bar("encode", encode_by.median, 0.55);
  bar("decode", decode_by.median, 0.55);
  return {{"dataset", data.name},
          {"grid_bits", data.bits},
          {"setting", "octree context, 2 slabs, 2 threads"},
          {"voxels", data.cloud.size()},
          {"bits_per_voxel", bits},
          {"encode_ms", to_json(encoding)},
          {"decode_ms", to_json(decoding)},
          {"size_ratio", size},
          {"encode_ratio", to_json(encode_by)},
          {"decode_ratio", to_json(decode_by)},
          {"encode_critical_path_ratio", to_json(encode_critical)},
          {"decode_critical_path_ratio", to_json(decode_critical)}};
}

}  // namespace

nlohmann::json run_grids(const SuiteOptions& options, std::vector<Bar>& bars) {
  const int runs = options.quick ? 3 : 9;
  print("\nGeometry of voxels, one thread: medians of {} runs, ratios to Draco\n", runs);
  print("{:<22} {:>4} {:<16} {:>9} {:>9} {:>9} {:>9} {:>8} {:>7} {:>7}\n", "dataset", "grid",
        "setting", "voxels", "bits/vox", "encode ms", "decode ms", "size", "encode", "decode");
  auto rows = nlohmann::json::array();
  const auto add = [&](const GriddedCloud& data, bool dense) {
    for (auto& row : run_grid(data, runs, bars, dense)) rows.push_back(std::move(row));
  };
  const Body body = pose_body(find_motion("walk")->pose(0.5));
  const auto voxels = voxelize(body, voxel_grid(bounds(body.surface), 10));
  if (voxels) {
    const GriddedCloud dense = gridded("dense figure", *voxels, 10);
    add(dense, true);
    if (auto row = run_slabs(dense, runs, bars); !row.is_null()) rows.push_back(std::move(row));
  }
  for (const std::filesystem::path& file : options.files) {
    const auto loaded = read_cloud_file(file);
    if (!loaded || loaded->cloud.empty()) continue;  // run_rates reports it
    const std::optional<int> own = own_bits(loaded->cloud);
    for (const int bits : own ? std::vector{*own} : std::vector{10, kFinestBits}) {
      add(gridded(file.filename().string(), loaded->cloud, bits), false);
    }
  }
  return rows;
}

}  // namespace pointreel::bench
