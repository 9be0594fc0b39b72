#include "tests/window/moving_plate.h"

#include <cmath>

#include <fmt/format.h>

#include "codec/files/ply.h"
#include "tests/e2e/process.h"

namespace pointreel::window {
namespace {

namespace fs = std::filesystem;

PointCloud plate(int frame) {
  PointCloud cloud;
  const float left = 2.0f * static_cast<float>(frame) / (MovingPlate::kFrames - 1);
  constexpr int kSide = 24;  // neighbouring frames are farther apart than voxels of the base layer
  for (int i = 0; i < kSide * kSide; ++i) {
    cloud.positions.emplace_back(left + 0.02f * static_cast<float>(i % kSide),
                                 0.02f * static_cast<float>(i / kSide), 0.0f);
    cloud.normals.emplace_back(0.0f, 0.0f, 1.0f);
    cloud.colors.emplace_back(60'000, 3'000, 3'000);
  }
  return cloud;
}

/// The distance to the right of the middle in picture heights, which is the same for all picture
/// sizes.
double place(const e2e::Picture& picture, const e2e::Patch& patch) {
  return (patch.center.x - 0.5 * picture.size.x) / picture.size.y;
}

}  // namespace

e2e::Patch MovingPlate::plate(const e2e::Picture& picture) {
  return e2e::find_hue(e2e::rows(picture, picture.size.y / 4, picture.size.y * 3 / 4), {1, 0, 0});
}

fs::path MovingPlate::ply(int frame) const { return folder_ / fmt::format("in/{}.ply", frame); }

Result<MovingPlate> MovingPlate::make(const fs::path& folder) {
  MovingPlate made;
  made.folder_ = folder;
  made.reel_ = (folder / "plate").string();
  std::error_code error;
  fs::create_directories(folder / "in", error);
  for (int frame = 0; frame < kFrames; ++frame) {
    if (auto written = write_ply(made.ply(frame), window::plate(frame)); !written)
      return tl::unexpected(written.error());
  }
  const e2e::Outcome packed =
      e2e::run("pointreel-server", {"pack", "-i", (folder / "in").string(), "-o", made.reel_,
                                    "--fps", std::to_string(kFps), "--force"});
  if (packed.exit_code != 0) return fail(packed.err);
  for (const int frame : {0, kFrames - 1}) {
    const std::string png = (folder / "plate.png").string();
    const e2e::Outcome drawn = e2e::run(
        "pointreel", {"play", made.reel_, "--at", fmt::format("{}", frame / double{kFps} + 0.01),
                      "--offscreen", "640x360", "--screenshot", png});
    if (drawn.exit_code != 0) return fail(drawn.err);
    const e2e::Picture picture = e2e::read_picture(png);
    const e2e::Patch patch = plate(picture);
    if (patch.pixels == 0) return fail("no plate in " + png);
    (frame == 0 ? made.first_ : made.last_) = place(picture, patch);
  }
  return made;
}

std::optional<int> MovingPlate::frame(const e2e::Picture& picture) const {
  if (picture.pixels.empty()) return std::nullopt;
  const e2e::Patch patch = plate(picture);
  if (patch.pixels < 50) return std::nullopt;
  const double along = (place(picture, patch) - first_) / (last_ - first_);
  return static_cast<int>(std::lround(along * (kFrames - 1)));
}

}  // namespace pointreel::window
