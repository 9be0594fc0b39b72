#include <fmt/format.h>

#include "codec/octree/frame_header.h"
#include "codec/octree/octree_codec.h"
#include "common/process/print.h"
#include "pointreel/chunks.h"
#include "pointreel/codec.h"
#include "pointreel/draco.h"
#include "tests/bench/clouds.h"
#include "tests/bench/codec_rates.h"
#include "tests/bench/grid_suite.h"
#include "tests/bench/measure.h"
#include "tests/bench/suites.h"
#include "tests/bench/video_rates.h"

namespace pointreel::bench {
namespace {

constexpr int kDepth = 10;

/// The limits of the entropy codings without contexts, in milliseconds.
struct Limits {
  Entropy entropy;
  double encode, decode;
};
constexpr Limits kLimits[] = {{Entropy::none, 2.0, 1.0}, {Entropy::zstd, 3.0, 1.2}};

/// The bits of the masks, without headers, per inner node.
double bits_an_inner_node(const EncodedFrame& frame, const Svo& svo) {
  std::size_t bytes = 0;
  for (const Chunks<Bytes>& layer : frame.layers) bytes += layer.geometry.size();
  bytes -= kFrameHeaderSize + frame.layers.size() * kChunkHeaderSize;
  return 8.0 * static_cast<double>(bytes) / svo.internal_count();
}

/// The speed of geometry alone, on a frame as large as those of Slomp et al.: from points to bytes,
/// and from bytes to a tree.
nlohmann::json run_plain(const SuiteOptions& options, std::vector<Bar>& bars) {
  const PointCloud scan = scan_like_cloud(88'315);
  const Cube cube = bounding_cube(bounds(scan));
  const int runs = options.quick ? 5 : 25;
  print("Positions of 88,315 points like a scanner's, depth {}, one thread, median of {} runs\n",
        kDepth, runs);
  print("{:<16} {:>8} {:>12} {:>10} {:>14}\n", "entropy", "bits/pt", "bits/inner", "encode ms",
        "to a tree, ms");
  auto rows = nlohmann::json::array();
  for (const Limits& limits : kLimits) {
    OctreeOptions octree;
    octree.entropy = limits.entropy;
    octree.depth = DepthRule::fixed(kDepth);
    const EncodeOptions encoding{octree, false, false};
    const auto frame = encode_frame(scan, cube, encoding);
    const auto layers = frame ? layer_views(frame->layers) : std::vector<Chunks<ByteView>>{};
    const auto tree = decode_octree_tree(layers, {});
    if (!tree) {
      print_error("pointreel-bench", tree.error().message);
      continue;
    }
    const Timing encode = measure(runs, [&] { (void)encode_frame(scan, cube, encoding); });
    const Timing decode = measure(runs, [&] { (void)decode_octree_tree(layers, {}); });
    const double inner = bits_an_inner_node(*frame, tree->svo);
    const double bits = 8.0 * static_cast<double>(frame->size()) / static_cast<double>(scan.size());
    print("{:<16} {:>8.3f} {:>12.3f} {:>10.2f} {:>14.2f}\n", name(limits.entropy), bits, inner,
          encode.median, decode.median);
    rows.push_back({{"entropy", name(limits.entropy)},
                    {"bits_per_point", bits},
                    {"bits_per_inner_node", inner},
                    {"encode_ms", to_json(encode)},
                    {"decode_to_svo_ms", to_json(decode)}});
    const std::string subject = fmt::format("octree {}, 88,315 points: ", name(limits.entropy));
    if (limits.entropy == Entropy::none) {
      bars.push_back({subject + "bits per inner node", inner, "bits", 8.0});
    }
    bars.push_back({subject + "encode", encode.median, "ms", limits.encode});
    bars.push_back({subject + "decode to an SVO", decode.median, "ms", limits.decode});
  }
  return rows;
}

}  // namespace

nlohmann::json run_codec(const SuiteOptions& options) {
  std::vector<Bar> bars;
  auto plain = run_plain(options, bars);
  auto grids = run_grids(options, bars);
  auto attributes = nlohmann::json::array();
  run_attributes(options, attributes, bars);
  auto rates = run_rates(options);
  auto video = run_video(options);
  print(bars, options.quick);
  return {{"plain", std::move(plain)},           {"grids", std::move(grids)},
          {"attributes", std::move(attributes)}, {"rates", std::move(rates)},
          {"video", std::move(video)},           {"bars", to_json(bars, options.quick)}};
}

}  // namespace pointreel::bench
