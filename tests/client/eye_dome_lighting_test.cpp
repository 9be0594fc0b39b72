#include "client/render/opengl/eye_dome_lighting.h"

#include <memory>

#include <gtest/gtest.h>

#include "tests/client/drawing_test.h"

namespace pointreel::eye_dome_lighting_test {
namespace {

constexpr glm::ivec2 kSize(160, 120);

/// Adds a square sheet of grey surfels that faces the eye, with edges of length `edge` and its
/// centre at `at`.
void add_sheet(PointCloud& cloud, const glm::vec3& at, float edge) {
  constexpr int kPoints = 40;
  for (int i = 0; i < kPoints * kPoints; ++i) {
    const glm::vec2 p = glm::vec2(i % kPoints, i / kPoints) / (kPoints - 1.0f) - 0.5f;
    cloud.positions.push_back(at + glm::vec3(edge * p, 0.0f));
    cloud.normals.emplace_back(0.0f, 0.0f, 1.0f);
    cloud.colors.emplace_back(0x8000, 0x8000, 0x8000);
    cloud.radii.push_back(edge / kPoints);
  }
}

class EyeDomeLightingTest : public DrawingTest {
 protected:
  EyeDomeLightingTest() {
    auto frame = std::make_shared<SceneFrame>();
    add_sheet(frame->cloud, {0.0f, 0.0f, 0.0f}, 1.6f);
    add_sheet(frame->cloud, {0.0f, 0.0f, 0.5f}, 0.6f);
    frame_ = frame;
  }

  Image picture(DrawMode mode, float edl) {
    DrawOptions options;
    options.mode = mode;
    options.edl = edl;
    options.lighting = false;
    options.point_size = 4.0f;
    Camera camera;
    camera.distance = 4.0;
    return draw(frame_, camera, kSize, options);
  }

  std::shared_ptr<const SceneFrame> frame_;
};

INSTANTIATE_TEST_SUITE_P(, EyeDomeLightingTest, kBothRenderers, renderer_name);

TEST_P(EyeDomeLightingTest, darkens_only_pixels_that_lie_behind_their_neighbours) {
  for (const DrawMode mode : {DrawMode::surfel, DrawMode::point}) {
    const Image without = picture(mode, 0.0f), with = picture(mode, 1.0f);
    // The middle row shows from left to right the background, the sheet behind, its rim and the
    // sheet in front.
    int darker = 0, same = 0;
    for (int x = 0; x < kSize.x; ++x) {
      const int before = without.at(x, kSize.y / 2).r, after = with.at(x, kSize.y / 2).r;
      EXPECT_LE(after, before);
      darker += after + 20 < before ? 1 : 0;
      same += after + 2 >= before ? 1 : 0;
    }
    EXPECT_GE(darker, 2) << static_cast<int>(mode);
    EXPECT_LE(darker, 8) << static_cast<int>(mode);
    // A point is nearest in its middle, so that EDL shows some of the edges between points.
    EXPECT_GE(same, kSize.x - (mode == DrawMode::point ? 16 : 12)) << static_cast<int>(mode);
    EXPECT_EQ(with.at(kSize.x / 2, kSize.y / 2), without.at(kSize.x / 2, kSize.y / 2));
    EXPECT_EQ(with.at(0, 0), without.at(0, 0));
  }
}

TEST_P(EyeDomeLightingTest, darkens_more_as_its_strength_rises) {
  const auto sum = [](const Image& image) {
    long total = 0;
    for (const glm::u8vec3& pixel : image.pixels) total += pixel.r;
    return total;
  };
  const long none = sum(picture(DrawMode::surfel, 0.0f));
  const long some = sum(picture(DrawMode::surfel, 0.3f));
  const long more = sum(picture(DrawMode::surfel, 3.0f));
  EXPECT_GT(none, some);
  EXPECT_GT(some, more);
}

TEST_P(EyeDomeLightingTest, does_not_affect_the_next_picture) {
  const Image before = picture(DrawMode::surfel, 0.0f);
  picture(DrawMode::surfel, 2.0f);
  EXPECT_EQ(picture(DrawMode::surfel, 0.0f).pixels, before.pixels);
}

}  // namespace
}  // namespace pointreel::eye_dome_lighting_test
