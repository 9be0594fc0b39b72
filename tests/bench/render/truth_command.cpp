#include "tests/bench/render/truth_command.h"

#include <cmath>
#include <cstdint>
#include <memory>
#include <string>

#include <fmt/format.h>

#include "client/record/open_recorder.h"
#include "client/render/supersampling.h"
#include "client/scene/camera_path.h"
#include "common/base/try.h"
#include "common/process/print.h"
#include "common/process/progress.h"
#include "datasets_synthetic/motion.h"
#include "tests/bench/render/truth.h"

namespace pointreel::bench {
namespace {

struct Options {
  std::string sequence, record, camera;
  int frames = 0;  ///< 0: all
  int width = 640, height = 480, supersample = 2;
};

Result<void> write_truth(const Options& options) {
  const Motion* motion = find_motion(options.sequence);
  if (motion == nullptr)
    return fail(ErrorCode::not_found,
                options.sequence + ": no such sequence; pointreel-synth --list shows them all");
  const CameraPath path = TRY(load_camera_path(options.camera));
  TRY(check_recording(options.record));
  const glm::ivec2 size(options.width, options.height);
  const FrameRate rate{static_cast<std::uint64_t>(kPosesPerSecond), 1};
  const auto recorder = TRY(open_recorder(options.record, size, rate));
  const int frames = options.frames > 0 ? options.frames : motion->poses;
  Progress progress("cast", static_cast<std::size_t>(frames));
  for (int frame = 0; frame < frames; ++frame) {
    const double seconds = frame / kPosesPerSecond;
    const auto scene = make_truth_scene(pose_body(motion->pose(seconds)));
    if (!scene) return fail_at(options.sequence, scene.error());
    Camera framed;
    framed.frame_bounds(bounds(scene->body.surface), static_cast<double>(size.x) / size.y);
    const auto time_us = static_cast<std::uint64_t>(std::llround(1e6 * seconds));
    const TruthPicture picture =
        cast_truth(*scene, path.at(time_us, framed), options.supersample * size, {});
    const Image image = average_squares(picture.image, options.supersample);
    TRY(recorder->add(image, time_us));
    progress.tick();
  }
  return recorder->finish(static_cast<std::uint64_t>(std::llround(1e6 * frames / kPosesPerSecond)));
}

}  // namespace

void add_truth_command(cli::Command app, int& exit_code) {
  const cli::Command command = app.add_subcommand(
      "truth", "records the true surface of a sequence by casting rays, like play --record");
  const auto options = std::make_shared<Options>();
  command.add_option("SEQUENCE", options->sequence, "a name that pointreel-synth --list shows")
      .required();
  command.add_option("--record", options->record, "a video (.mp4, .mkv, .webm) or out-%04d.png")
      .required();
  command.add_option("--camera", options->camera, "file with the camera path, including targets")
      .required();
  command.add_option("--frames", options->frames, "stop after this many frames")
      .check(cli::range(1, 100'000));
  command.add_option("--width", options->width, "width of the pictures in pixels")
      .check(cli::range(1, 4096))
      .capture_default_str();
  command.add_option("--height", options->height, "height of the pictures in pixels")
      .check(cli::range(1, 4096))
      .capture_default_str();
  command.add_option("--supersample", options->supersample, "rays per pixel along each side")
      .check(cli::range(1, 4))
      .capture_default_str();
  command.callback([options, &exit_code] {
    const auto written = write_truth(*options);
    if (written) return;
    print_error("pointreel-bench", written.error().message);
    exit_code = 1;
  });
}

}  // namespace pointreel::bench
