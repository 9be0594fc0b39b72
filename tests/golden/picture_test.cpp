// Tests the pictures of tests/golden/pictures. README.md describes them.
//
//   pointreel_golden_pictures               tests them
//   pointreel_golden_pictures --make DIR    draws them again

#include "tests/e2e/picture.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "client/render/opengl/gl_context.h"
#include "tests/golden/picture_cases.h"
#include "tests/paths.h"

namespace pointreel::golden::picture_test {
namespace {

const std::filesystem::path kFolder = source_folder() / "tests/golden/pictures";

/// Drivers round differently at the edges of splats, so kPixels pixels may differ by more than
/// kStep of 255 in a channel.
constexpr int kStep = 10;
constexpr std::size_t kPixels = 12;

Result<std::map<std::string, Image>> draw(const PointCloud& cloud) {
  auto context = OffscreenContext::create();
  if (!context) return fail(context.error().message);
  auto renderer = GlRenderer::create();
  if (!renderer) return fail(renderer.error().message);
  std::map<std::string, Image> pictures;
  for (const PictureCase& one : picture_cases(cloud)) {
    if (auto drawn = renderer->draw(one.frame, one.camera, kPictureSize, one.options); !drawn)
      return fail(drawn.error().message);
    auto image = renderer->read_pixels();
    if (!image) return fail(image.error().message);
    pictures.emplace(one.name, std::move(*image));
  }
  return pictures;
}

/// The number of pixels that differ too much.
std::size_t changed(const std::vector<glm::u8vec3>& was, const Image& is) {
  if (was.size() != is.pixels.size()) return std::max(was.size(), is.pixels.size());
  std::size_t count = 0;
  for (std::size_t i = 0; i < was.size(); ++i) {
    const glm::ivec3 d = glm::abs(glm::ivec3(was[i]) - glm::ivec3(is.pixels[i]));
    count += std::max({d.x, d.y, d.z}) > kStep ? 1u : 0u;
  }
  return count;
}

std::vector<glm::u8vec3> stored(const std::string& name) {
  return e2e::read_picture(kFolder / (name + ".png")).pixels;
}

/// The names of the pictures that would fail.
std::vector<std::string> noticed(const PointCloud& cloud) {
  const auto pictures = draw(cloud);
  EXPECT_TRUE(pictures) << pictures.error().message;
  std::vector<std::string> names;
  if (!pictures) return names;
  for (const auto& [name, picture] : *pictures)
    if (changed(stored(name), picture) > kPixels) names.push_back(name);
  return names;
}

std::vector<std::string> all_but(const std::vector<std::string_view>& exceptions) {
  std::vector<std::string> names;
  for (const PictureCase& one : picture_cases(picture_cloud()))
    if (std::ranges::find(exceptions, one.name) == exceptions.end()) names.push_back(one.name);
  std::ranges::sort(names);
  return names;
}

TEST(GoldenPictures, every_way_to_draw_still_gives_its_picture) {
  const auto pictures = draw(picture_cloud());
  ASSERT_TRUE(pictures) << pictures.error().message;
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(kFolder))
    files += entry.path().extension() == ".png" ? 1u : 0u;
  EXPECT_EQ(files, pictures->size());
  for (const auto& [name, picture] : *pictures) {
    const std::size_t pixels = changed(stored(name), picture);
    EXPECT_LE(pixels, kPixels) << name;
    if (pixels > kPixels) {
      const auto file = std::filesystem::temp_directory_path() / ("pointreel-" + name + ".png");
      if (write_png(file, picture)) fmt::print(stderr, "what was drawn: {}\n", file.string());
    }
  }
}

TEST(GoldenPictures, a_shifted_splat_is_noticed) {
  PointCloud cloud = picture_cloud();
  const std::size_t i = middle_surfel();
  const glm::vec3 across = glm::normalize(glm::cross(cloud.normals[i], {0.0f, 1.0f, 0.0f}));
  cloud.positions[i] += 0.5f * cloud.radii[i] * across;
  // The shift is not noticed where cells of the octree are larger, where colours are made from
  // normals, which are smooth, or from inside, where the splat is out of view.
  EXPECT_EQ(noticed(cloud), all_but({"voxel-faces", "voxel-cubes", "voxel-coarse",
                                     "surfel-without-colors", "surfel-inside"}));
}

TEST(GoldenPictures, a_flipped_normal_is_noticed) {
  PointCloud cloud = picture_cloud();
  cloud.normals[middle_surfel()] *= -1.0f;
  EXPECT_EQ(noticed(cloud),
            all_but({"surfel-either-side", "surfel-without-normals", "surfel-inside"}));
}

TEST(GoldenPictures, swapped_channels_are_noticed) {
  PointCloud cloud = picture_cloud();
  for (glm::u16vec3& color : cloud.colors) std::swap(color.r, color.b);
  EXPECT_EQ(noticed(cloud), all_but({"surfel-without-colors"}));
}

TEST(GoldenPictures, mirrored_axes_are_noticed) {
  for (int axis = 0; axis < 3; ++axis) {
    PointCloud cloud = picture_cloud();
    for (glm::vec3& p : cloud.positions) p[axis] *= -1.0f;
    for (glm::vec3& n : cloud.normals) n[axis] *= -1.0f;
    EXPECT_EQ(noticed(cloud), all_but({})) << axis;
  }
}

}  // namespace
}  // namespace pointreel::golden::picture_test

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  if (argc == 3 && std::string_view(argv[1]) == "--make") {
    const auto pictures = pointreel::golden::picture_test::draw(pointreel::golden::picture_cloud());
    if (!pictures) {
      fmt::print(stderr, "pointreel_golden_pictures: {}\n", pictures.error().message);
      return 1;
    }
    for (const auto& [name, picture] : *pictures) {
      const auto written =
          pointreel::write_png(std::filesystem::path(argv[2]) / (name + ".png"), picture);
      if (!written) fmt::print(stderr, "pointreel_golden_pictures: {}\n", written.error().message);
      if (!written) return 1;
    }
    return 0;
  }
  return RUN_ALL_TESTS();
}
