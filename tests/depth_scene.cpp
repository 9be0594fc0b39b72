#include "tests/depth_scene.h"

#include <cmath>
#include <cstddef>
#include <fstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <png.h>

#include "common/base/try.h"
#include "common/process/run_program.h"

namespace pointreel::depth_scene {
namespace {

constexpr double kRadius = 0.4;
const glm::dvec3 kWall = glm::normalize(glm::dvec3(0.15, -0.3, 1.0));
constexpr double kWallDistance = 2.4;

glm::dvec3 ball(int frame) { return {-0.5 + 0.1 * frame, 0.05, 1.5}; }

std::string png(std::uint32_t width, std::uint32_t height, std::uint32_t format,
                const void* pixels) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = width;
  image.height = height;
  image.format = format;
  png_alloc_size_t size = 0;
  png_image_write_to_memory(&image, nullptr, &size, 0, pixels, 0, nullptr);
  std::string bytes(size, '\0');
  png_image_write_to_memory(&image, bytes.data(), &size, 0, pixels, 0, nullptr);
  bytes.resize(size);
  return bytes;
}

}  // namespace

CameraIntrinsics camera(std::uint32_t width, double steps_per_meter) {
  CameraIntrinsics camera;
  camera.width = width;
  camera.height = width * 3 / 4;
  camera.fx = 0.85 * width;
  camera.fy = 0.9 * width;
  camera.cx = 0.51 * width;
  camera.cy = 0.36 * width;
  camera.steps_per_meter = steps_per_meter;
  return camera;
}

std::string intrinsics(const CameraIntrinsics& camera) {
  return fmt::format(
      "{{\"width\": {}, \"height\": {}, \"intrinsic_matrix\": [{}, 0.0, 0.0, 0.0, {}, 0.0, {}, {}, "
      "1.0], \"depth_scale\": {}}}",
      camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy,
      camera.steps_per_meter);
}

Seen look(const CameraIntrinsics& camera, double u, double v, int frame) {
  const glm::dvec3 ray((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1.0);
  const glm::dvec3 center = ball(frame);
  const double a = glm::dot(ray, ray), b = glm::dot(ray, center);
  const double root = b * b - a * (glm::dot(center, center) - kRadius * kRadius);
  if (root > 0.0) {
    const double depth = (b - std::sqrt(root)) / a;
    return {depth, glm::normalize(depth * ray - center), true};
  }
  return {kWallDistance / glm::dot(kWall, ray), -kWall, false};
}

DepthPicture depth(const CameraIntrinsics& camera, int frame) {
  DepthPicture picture{camera.width, camera.height, {}};
  for (std::uint32_t y = 0; y < camera.height; ++y) {
    for (std::uint32_t x = 0; x < camera.width; ++x)
      picture.values.push_back(static_cast<std::uint16_t>(
          std::lround(look(camera, x, y, frame).depth * camera.steps_per_meter)));
  }
  return picture;
}

ColorPicture color(const CameraIntrinsics& camera, int frame) {
  ColorPicture picture{camera.width, camera.height, {}};
  for (std::uint32_t y = 0; y < camera.height; ++y) {
    for (std::uint32_t x = 0; x < camera.width; ++x) {
      const bool ball = look(camera, x, y, frame).ball;
      picture.rgb.push_back(ball ? 220 : 40);
      picture.rgb.push_back(static_cast<std::uint8_t>(ball ? 30 : 60 + 160 * x / camera.width));
      picture.rgb.push_back(static_cast<std::uint8_t>(ball ? 30 : 60 + 160 * y / camera.height));
    }
  }
  return picture;
}

std::string png(const DepthPicture& picture) {
  return png(picture.width, picture.height, PNG_FORMAT_LINEAR_Y, picture.values.data());
}

std::string png(const ColorPicture& picture) {
  return png(picture.width, picture.height, PNG_FORMAT_RGB, picture.rgb.data());
}

void write(const std::filesystem::path& folder, int frames, const CameraIntrinsics& camera) {
  const auto put = [&](const std::string& name, const std::string& content) {
    std::filesystem::create_directories((folder / name).parent_path());
    std::ofstream(folder / name, std::ios::binary) << content;
  };
  put("intrinsic.json", intrinsics(camera));
  for (int frame = 0; frame < frames; ++frame) {
    put(fmt::format("depth/{}.png", frame), png(depth(camera, frame)));
    put(fmt::format("color/{}.png", frame), png(color(camera, frame)));
  }
}

Result<void> write_video(const std::filesystem::path& folder, const std::filesystem::path& video,
                         int fps) {
  std::filesystem::copy_file(folder / "intrinsic.json",
                             std::filesystem::path(video).replace_extension(".json"));
  std::vector<std::string> arguments = {"ffmpeg", "-loglevel", "error"};
  for (const char* pictures : {"depth/%d.png", "color/%d.png"})
    for (const std::string& argument : {std::string("-framerate"), std::to_string(fps),
                                        std::string("-i"), (folder / pictures).string()})
      arguments.push_back(argument);
  for (const char* argument :
       {"-map", "0", "-map", "1", "-c:v:0", "ffv1", "-pix_fmt:v:0", "gray16le", "-c:v:1", "mjpeg",
        "-q:v:1", "2", "-pix_fmt:v:1", "yuvj420p"})
    arguments.emplace_back(argument);
  arguments.push_back(video.string());
  const ProgramOutcome made = TRY(run_program(arguments));
  if (made.exit_code != 0) return fail(made.out);
  return {};
}

}  // namespace pointreel::depth_scene
