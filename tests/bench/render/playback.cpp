#include "tests/bench/render/playback.h"

#include <string>
#include <system_error>

#include "common/base/try.h"
#include "tests/bench/program.h"

namespace pointreel::bench {

using nlohmann::json;

Result<json> play_reel(const std::string& reel, const std::string& mode,
                       const std::string& renderer) {
  const std::string out =
      TRY(run_program("pointreel", {"play", reel, "--mode", mode, "--renderer", renderer,
                                    "--offscreen", "1280x720", "--json", "-"}))
          .out;
  const json played = json::parse(out, nullptr, false);
  if (played.is_discarded()) return fail("pointreel play printed no JSON");
  json row = {{"mode", mode}, {"fps", played["fps"]}, {"frames", played["frames_shown"]}};
  for (const char* stage : {"decode_ms", "normals_ms", "svo_ms", "cut_ms", "render_ms"}) {
    row[stage] = played[stage]["median"];
  }
  return row;
}

Result<json> measure_playback(const std::filesystem::path& folder, int frames) {
  const std::filesystem::path scratch = folder / ".playback";
  const std::string clouds = scratch / "clouds", reel = scratch / "reel";
  std::error_code ignored;
  std::filesystem::remove_all(scratch, ignored);
  const auto measure = [&]() -> Result<json> {
    TRY(run_program("pointreel-synth",
                    {"soccer-shoot", "-o", clouds, "--frames", std::to_string(frames)}));
    TRY(run_program("pointreel-server", {"pack", "-i", clouds, "-o", reel, "--codec", "octree"}));
    json rows = json::array();
    for (const char* mode : {"surfel", "voxel", "point"})
      rows.push_back(TRY(play_reel(reel, mode, "opengl")));
    return rows;
  };
  auto rows = measure();
  std::filesystem::remove_all(scratch, ignored);
  return rows;
}

}  // namespace pointreel::bench
