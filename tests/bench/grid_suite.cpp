#include "tests/bench/grid_suite.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <string>

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "codec/cloud_file.h"
#include "codec/codec.h"
#include "codec/octree/octree_codec.h"
#include "datasets_synthetic/body.h"
#include "datasets_synthetic/motion.h"
#include "datasets_synthetic/voxelize.h"

namespace pointreel::bench {
namespace {

/// Points in the middle of the cells of a cube of 2^bits cells a side, of edge 1 each.
struct GriddedCloud {
  std::string name;
  PointCloud cloud;
  int bits = 10;

  Cube cube() const { return {glm::dvec3(0.0), std::ldexp(1.0, bits)}; }
};

GriddedCloud gridded(std::string name, const PointCloud& cloud, int bits) {
  const Box box = bounds(cloud);
  const glm::dvec3 extent = box.max - box.min;
  const double edge = std::max({extent.x, extent.y, extent.z, 1e-300});
  const double cells = std::ldexp(1.0, bits) - 1.0;
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

/// What the project wants of a frame that is known by name (issue 4).
struct Wanted {
  const char* file;
  int bits;
  double bits_a_point, encode_ms, decode_ms;
};
constexpr Wanted kWanted[] = {{"Guanyin.ply", 10, 6.50, 18, 24},
                              {"Guanyin.ply", 12, 12.4, 60, 70},
                              {"0000.ply", 10, 6.55, 7, 9}};

struct Figures {
  double bits_a_point = 0.0;
  Timing encode, decode;
};

Result<Figures> measure_coding(const GriddedCloud& data, const EncodeOptions& options, int runs) {
  const auto frame = encode_frame(data.cloud, data.cube(), options);
  if (!frame) return tl::unexpected(frame.error());
  const auto layers = layer_views(frame->layers);
  const auto decoded = decode_frame(layers);
  if (!decoded) return tl::unexpected(decoded.error());
  if (decoded->cloud.size() != data.cloud.size()) return fail("points were lost");
  Figures figures;
  figures.bits_a_point =
      8.0 * static_cast<double>(frame->size()) / static_cast<double>(data.cloud.size());
  figures.encode = measure(runs, [&] { (void)encode_frame(data.cloud, data.cube(), options); });
  // An octree frame is decoded when its tree is there: that is what is drawn.
  figures.decode = options.id() == Codec::octree
                       ? measure(runs, [&] { (void)decode_octree_tree(layers, {}); })
                       : measure(runs, [&] { (void)decode_frame(layers); });
  return figures;
}

/// Two slabs on two threads against one slab on one, the runs taking turns.
void add_thread_bars(const GriddedCloud& data, int runs, std::vector<Bar>& bars) {
  const Executor threads = [](int count, const std::function<void(int)>& body) {
    tbb::task_arena(2).execute([&] { tbb::parallel_for(0, count, body); });
  };
  std::array<EncodeOptions, 2> options;
  std::array<DecodeLimits, 2> limits;
  std::array<EncodedFrame, 2> frames;
  for (const std::size_t i : {0u, 1u}) {
    OctreeOptions octree{Entropy::context, DepthRule::fixed(data.bits)};
    octree.slabs = static_cast<int>(i) + 1;
    options[i] = {octree, false, false};
    if (i == 1) options[i].executor = limits[i].executor = threads;
    auto frame = encode_frame(data.cloud, data.cube(), options[i]);
    if (!frame) return fmt::print(stderr, "pointreel-bench: {}\n", frame.error().message);
    frames[i] = std::move(*frame);
  }
  std::array<std::vector<double>, 2> encode, decode;
  for (int run = 0; run < runs; ++run) {
    for (const std::size_t i : {0u, 1u}) {
      const double begin = now_ms();
      (void)encode_frame(data.cloud, data.cube(), options[i]);
      const double middle = now_ms();
      (void)decode_octree_tree(layer_views(frames[i].layers), limits[i]);
      encode[i].push_back(middle - begin);
      decode[i].push_back(now_ms() - middle);
    }
  }
  const auto bar = [&](const char* what, double two, double one, double limit) {
    bars.push_back(
        {fmt::format("two threads against one, {}: {}", data.name, what), two / one, "x", limit});
  };
  bar("size", static_cast<double>(frames[1].size()), static_cast<double>(frames[0].size()), 1.015);
  bar("encode", summarise(encode[1]).median, summarise(encode[0]).median, 0.55);
  bar("decode", summarise(decode[1]).median, summarise(decode[0]).median, 0.55);
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
      fmt::print(stderr, "pointreel-bench: {}, {}: {}\n", data.name, name, figures.error().message);
      continue;
    }
    if (!peer) peer = *figures;
    best = *figures;
    fmt::print(
        "{:<22} {:>4} {:<16} {:>9} {:>9.4f} {:>9.2f} {:>9.2f} {:>8.3f} {:>7.3f} {:>7.3f}\n",
        data.name, data.bits, name, data.cloud.size(), figures->bits_a_point,
        figures->encode.median, figures->decode.median, figures->bits_a_point / peer->bits_a_point,
        figures->encode.median / peer->encode.median, figures->decode.median / peer->decode.median);
    rows.push_back({{"dataset", data.name},
                    {"grid_bits", data.bits},
                    {"setting", name},
                    {"voxels", data.cloud.size()},
                    {"bits_per_voxel", figures->bits_a_point},
                    {"encode_ms", to_json(figures->encode)},
                    {"decode_ms", to_json(figures->decode)}});
  }
  const auto bar = [&](const char* what, double value, const char* unit, double limit) {
    bars.push_back({fmt::format("context, {} at {} bits: {}", data.name, data.bits, what), value,
                    unit, limit});
  };
  if (dense && peer) {
    bar("size against Draco", best.bits_a_point / peer->bits_a_point, "x", 0.16);
    bar("encode against Draco", best.encode.median / peer->encode.median, "x", 0.13);
    bar("decode against Draco", best.decode.median / peer->decode.median, "x", 0.42);
  }
  if (dense) add_thread_bars(data, runs, bars);
  for (const Wanted& wanted : kWanted) {
    if (wanted.file != data.name || wanted.bits != data.bits) continue;
    bar("bits a voxel", best.bits_a_point, "bits", wanted.bits_a_point);
    bar("encode", best.encode.median, "ms", wanted.encode_ms);
    bar("decode to an SVO", best.decode.median, "ms", wanted.decode_ms);
  }
  return rows;
}

}  // namespace

nlohmann::json run_grids(const SuiteOptions& options, std::vector<Bar>& bars) {
  const int runs = options.quick ? 3 : 9;
  fmt::print("\nGeometry of voxels, one thread: medians of {} runs, ratios against Draco\n", runs);
  fmt::print("{:<22} {:>4} {:<16} {:>9} {:>9} {:>9} {:>9} {:>8} {:>7} {:>7}\n", "dataset", "grid",
             "setting", "voxels", "bits/vox", "encode ms", "decode ms", "size", "encode", "decode");
  auto rows = nlohmann::json::array();
  const auto add = [&](const GriddedCloud& data, bool dense) {
    for (auto& row : run_grid(data, runs, bars, dense)) rows.push_back(std::move(row));
  };
  const Body body = pose_body(find_motion("walk")->pose(0.5));
  const auto voxels = voxelize(body, voxel_grid(bounds(body.surface), 10));
  if (voxels) add(gridded("dense figure", *voxels, 10), true);
  for (const std::filesystem::path& file : options.files) {
    const auto loaded = read_cloud_file(file);
    if (!loaded || loaded->cloud.empty()) continue;  // the table before has said so
    for (const int bits : {10, 12}) {
      add(gridded(file.filename().string(), loaded->cloud, bits), false);
    }
  }
  return rows;
}

}  // namespace pointreel::bench
