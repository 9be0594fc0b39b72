#include "tests/bench/stream/camera_path.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "client/playback/reel_playback.h"
#include "client/render/opengl/gl_context.h"
#include "client/render/opengl/gl_renderer.h"
#include "client/render/supersampling.h"
#include "client/source/open_source.h"
#include "codec/package/manifest.h"
#include "common/base/try.h"
#include "datasets_synthetic/motion.h"
#include "tests/bench/render/image_error.h"
#include "tests/bench/render/truth.h"
#include "tests/bench/stream/reels.h"

namespace pointreel::bench {
namespace {

using nlohmann::json;

constexpr glm::ivec2 kSize(640, 480);

/// Starts at twelve times the distance that shows the whole figure and approaches at an even rate,
/// to half that distance.
Camera camera_at(const Manifest& manifest, double share) {
  Camera camera;
  camera.up = manifest.up;
  camera.frame_bounds(manifest.bounds, static_cast<double>(kSize.x) / kSize.y);
  camera.zoom(12.0 * std::pow(0.5 / 12.0, share));
  return camera;
}

struct Walked {
  std::vector<Image> pictures;
  std::vector<Image> larger;  ///< the same pictures, drawn three times as large and averaged
  std::uint64_t bytes = 0;
};

/// The number of frames from one compared picture to the next.
std::uint32_t stride(const StreamedReel& reel, std::uint32_t pictures) {
  return (reel.packed_frames + pictures - 1) / pictures;
}

Result<Image> draw(Renderer& renderer, const std::shared_ptr<const SceneFrame>& frame,
                   const Camera& camera, int times) {
  DrawOptions options;
  options.pixel_size *= static_cast<float>(times);
  TRY(renderer.draw(frame, camera, times * kSize, options));
  const Image image = TRY(renderer.read_pixels());
  return times > 1 ? average_squares(image, times) : image;
}

/// Plays every frame once while the camera moves.
Result<Walked> walk(const StreamedReel& reel, Renderer& renderer, bool all_layers,
                    std::uint32_t pictures) {
  auto source = open_source(reel.packed.string());
  if (!source) return tl::unexpected(source.error());
  const Manifest& manifest = (*source)->manifest();
  const std::uint32_t frames = reel.packed_frames;
  const auto camera = [&](std::uint32_t frame) {
    return camera_at(manifest, static_cast<double>(frame) / (frames - 1));
  };
  ReelPlayback::Options options;
  options.loop = false;
  options.remote = true;  // what was fetched is kept, and refined as the camera comes nearer
  if (all_layers) options.prepare.pixel_size = 0.0f;
  ReelPlayback playback(std::move(*source), options, camera(0), kSize,
                        [](std::uint32_t, const Error&) {});
  Walked walked;
  for (std::uint32_t frame = 0; frame < frames; ++frame) {
    playback.look(camera(frame), kSize);
    const auto state = playback.await(frame, std::chrono::seconds(30));
    if (state != FrameBuffer::State::ready)
      return fail(fmt::format("frame {}: did not come", frame));
    if (frame % stride(reel, pictures) != 0) continue;
    walked.pictures.push_back(TRY(draw(renderer, playback.best(), camera(frame), 1)));
    if (!all_layers) continue;
    walked.larger.push_back(TRY(draw(renderer, playback.best(), camera(frame), 3)));
  }
  walked.bytes = playback.statistics().fetched_bytes;
  return walked;
}

/// The true picture of a frame of soccer-shoot.
Result<Image> truth_picture(const Manifest& manifest, const StreamedReel& reel,
                            std::uint32_t frame) {
  const Motion* motion = find_motion("soccer-shoot");
  const auto scene = TRY(make_truth_scene(pose_body(motion->pose(frame / kPosesPerSecond))));
  TruthStyle style;
  style.texture = manifest.colors;
  const double share = static_cast<double>(frame) / (reel.packed_frames - 1);
  return cast_truth(scene, camera_at(manifest, share), kSize, style).image;
}

double mean_error(const Image& a, const Image& b) {
  const auto value = psnr(a, b);
  return value ? std::pow(10.0, -*value / 10.0) : 0.0;
}

/// The PSNR of pictures with this sum of mean square errors.
double decibels(double errors, std::size_t pictures) {
  return -10.0 * std::log10(std::max(errors / static_cast<double>(pictures), 1e-12));
}

}  // namespace

Result<json> run_camera_path(const StreamOptions& options, std::vector<Bar>& bars) {
  const auto reels = TRY(streamed_reels(options));
  const auto context = TRY(OffscreenContext::create());
  GlRenderer renderer = TRY(GlRenderer::create());
  json rows = json::array();
  for (const StreamedReel& reel : reels) {
    const std::uint32_t pictures = std::min(reel.packed_frames, options.quick ? 4u : 10u);
    const Manifest manifest = TRY(read_manifest(reel.packed));
    const Walked chosen = TRY(walk(reel, renderer, false, pictures));
    const Walked whole = TRY(walk(reel, renderer, true, pictures));
    // The coordinates of the dense reel are voxel numbers, not metres, so truth_picture does not
    // fit them.
    const bool against_truth = reel.name == "soccer-shoot";
    double chosen_error = 0.0, whole_error = 0.0;
    for (std::size_t i = 0; i < chosen.pictures.size(); ++i) {
      const auto frame = static_cast<std::uint32_t>(i) * stride(reel, pictures);
      const Image reference =
          against_truth ? TRY(truth_picture(manifest, reel, frame)) : whole.larger[i];
      chosen_error += mean_error(reference, chosen.pictures[i]);
      whole_error += mean_error(reference, whole.pictures[i]);
    }
    const std::size_t count = chosen.pictures.size();
    const double chosen_db = decibels(chosen_error, count), whole_db = decibels(whole_error, count);
    const double fewer =
        100.0 * (1.0 - static_cast<double>(chosen.bytes) / static_cast<double>(whole.bytes));
    bars.push_back({fmt::format("camera path, {}: fewer bytes than all layers", reel.name), fewer,
                    "%", 40.0, true});
    bars.push_back(
        {fmt::format("camera path, {}: PSNR lost", reel.name), whole_db - chosen_db, "dB", 0.5});
    rows.push_back({{"reel", reel.name},
                    {"bytes", chosen.bytes},
                    {"bytes_of_all_layers", whole.bytes},
                    {"pictures", count},
                    {"against", against_truth ? "ray cast" : "all layers, three times as large"},
                    {"psnr", chosen_db},
                    {"psnr_of_all_layers", whole_db}});
  }
  return json{{"rows", rows}};
}

}  // namespace pointreel::bench
