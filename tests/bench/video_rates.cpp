#include "tests/bench/video_rates.h"

#include <numeric>
#include <vector>

#include <fmt/format.h>
#include <tbb/global_control.h>

#include "codec/files/ply.h"
#include "codec/segments/coding_error.h"
#include "common/base/try.h"
#include "common/process/print.h"
#include "server/inspect/inspect.h"
#include "server/pack/packer.h"
#include "server/store/package_files.h"
#include "tests/bench/measure.h"
#include "tests/bench/report/datasets.h"
#include "tests/temporary_folder.h"

namespace pointreel::bench {
namespace {

constexpr int kGroup = 24;  // frames

struct VideoSetting {
  const char* codec;
  int quality;
  std::optional<int> levels = {};  ///< of octrees, one for each factor of 2; all of them if empty
};

Result<void> write_frames(const std::filesystem::path& folder, int frames) {
  std::vector<int> poses(static_cast<std::size_t>(frames));
  std::iota(poses.begin(), poses.end(), 0);
  const std::vector<PointCloud> clouds = TRY(make_clouds(dense_dataset(), poses));
  std::filesystem::create_directories(folder);
  for (std::size_t i = 0; i < clouds.size(); ++i)
    TRY(write_ply(folder / fmt::format("{:03}.ply", i), clouds[i]));
  return {};
}

Result<nlohmann::json> measure_video(const VideoSetting& setting, const TemporaryFolder& folder) {
  PackOptions options;
  options.inputs = {folder / "frames"};
  options.output = folder / "reel";
  options.force = true;
  options.encode.normals = false;
  OctreeOptions octree;
  octree.color_quality = setting.quality;
  if (setting.levels) octree.depth = DepthRule::fixed(*setting.levels);
  options.encode.codec = octree;
  options.segment_frames = kGroup;
  if (std::string_view(setting.codec) == "video")
    options.video = VideoPackOptions{.group_frames = kGroup, .quality = setting.quality};
  const PackSummary summary = TRY(pack(options));
  const double pack_ms = 1000.0 * summary.seconds / summary.frames;
  const PackageFiles files(options.output);
  double verify_ms = 0.0;
  {
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    VerifyReport report;
    const Timing timing = measure(1, [&] { report = verify(files).value_or(VerifyReport{}); });
    if (report.frames != summary.frames || !report.faults.empty())
      return fail("the package cannot be verified");
    verify_ms = timing.median / summary.frames;
  }
  const double rate = summary.segments.front().bits_per_second / 1e6;
  print("{:<8} {:>8} {:>10.2f} {:>10.1f} {:>10.1f}   {}\n", setting.codec, setting.quality, rate,
        pack_ms, verify_ms, coding_error_text(summary.coding_error.value(), summary.peak));
  return nlohmann::json{{"codec", setting.codec},
                        {"quality", setting.quality},
                        {"mbit_per_second", rate},
                        {"pack_ms_per_frame", pack_ms},
                        {"verify_ms_per_frame", verify_ms},
                        {"error", coding_error_json(summary.coding_error, summary.peak)}};
}

}  // namespace

nlohmann::json run_video(const SuiteOptions& options) {
  const int frames = options.quick ? 4 : kGroup;
  auto rows = nlohmann::json::array();
  const TemporaryFolder folder;
  if (const auto written = write_frames(folder / "frames", frames); !written) {
    print_error("pointreel-bench", written.error().message);
    return rows;
  }
  std::vector<VideoSetting> settings{{"octree", 64}, {"octree", 64, 9}, {"video", 64}};
  if (!options.quick) {
    settings = {{"octree", 30}, {"octree", 64}, {"octree", 30, 9}, {"octree", 64, 9}, {"video", 20},
                {"video", 40},  {"video", 50},  {"video", 64},     {"video", 80}};
  }
  print("\nLayered depth video and octrees of the dense kick, {} frames at 30 a second\n", frames);
  print("{:<8} {:>8} {:>10} {:>10} {:>10}   {}\n", "codec", "quality", "Mbit/s", "pack ms",
        "verify ms", "error, of one frame");
  for (const VideoSetting& setting : settings) {
    auto row = measure_video(setting, folder);
    if (row) {
      rows.push_back(std::move(*row));
    } else {
      print_error("pointreel-bench", fmt::format("{}, quality {}: {}", setting.codec,
                                                 setting.quality, row.error().message));
    }
  }
  return rows;
}

}  // namespace pointreel::bench
