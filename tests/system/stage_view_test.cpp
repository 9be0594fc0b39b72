#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "client/playback/stage.h"
#include "tests/packed_reel.h"
#include "tests/wait.h"

namespace pointreel::stage_view_test {
namespace {

constexpr glm::ivec2 kSize(640, 360);

/// As the players do it.
Camera home(const Box& bounds, Up up) {
  Camera camera;
  camera.up = up;
  camera.frame_bounds(bounds, static_cast<double>(kSize.x) / kSize.y);
  return camera;
}

/// What the first camera sees of a cloud, as a folder and as a package.
class StageView : public PackTest {
 protected:
  void write(const PointCloud& cloud) {
    ASSERT_TRUE(write_ply(frames_ / "frame.ply", cloud));
    ASSERT_TRUE(pack(options()));  // which does not clean it of stray points
  }

  /// The camera once the view does not change any more.
  static Camera camera_of(const std::filesystem::path& source, DrawMode mode) {
    Stage::Options options;
    options.size = kSize;
    options.prepare.mode = mode;
    auto stage = Stage::open({{source.string(), {}}}, options, home, [](auto&&...) {});
    if (!stage) {
      ADD_FAILURE() << stage.error().message;
      return {};
    }
    ReelPlayback& reel = *(*stage)->reel(0);
    Camera camera = home((*stage)->view_bounds(), 'y');
    for (bool moved = true; moved;) {
      EXPECT_TRUE(wait_until([&] {
        return reel.await(0, std::chrono::milliseconds(50)) == FrameBuffer::State::ready;
      }));
      (*stage)->take(0, reel.best());
      const Camera next = home((*stage)->view_bounds(), 'y');
      moved = next != camera;
      camera = next;
      (*stage)->look(camera, kSize);
    }
    return camera;
  }

  /// For all modes, the camera of the folder and of the package, within this share of the distance
  /// of one that looks at this box.
  void expect_framed(const Box& box, double share) {
    const Camera expected = home(box, 'y');
    for (const DrawMode mode : {DrawMode::surfel, DrawMode::voxel, DrawMode::point})
      for (const auto& source : {frames_, reel_}) {
        const Camera camera = camera_of(source, mode);
        EXPECT_NEAR(camera.distance, expected.distance, share * expected.distance)
            << source << ", " << name(mode);
        EXPECT_LT(glm::distance(camera.target, expected.target), share * expected.distance)
            << source << ", " << name(mode);
      }
  }
};

/// About as wide and deep as a person is for its height.
PointCloud person(double x) {
  PointCloud cloud = ball(20'000, 0);
  for (glm::vec3& position : cloud.positions)
    position = position * glm::vec3(0.3f, 0.9f, 0.2f) + glm::vec3(x, 0.9f, 0.0f);
  return cloud;
}

const Box kPerson{{-0.3, 0.0, -0.2}, {0.3, 1.8, 0.2}};

TEST_F(StageView, is_the_same_of_a_folder_and_of_its_package) {
  write(person(0.0));
  expect_framed(kPerson, 0.01);
}

TEST_F(StageView, does_not_lose_a_person_for_one_stray_point) {
  for (const float away : {20.0f, 180.0f}) {
    PointCloud cloud = person(0.0);
    cloud.positions[7'000] = {-away, 0.5f * away, away};
    write(cloud);
    expect_framed(kPerson, 0.05);
    std::filesystem::remove_all(reel_);
  }
}

TEST_F(StageView, shows_two_people_who_stand_far_apart) {
  PointCloud both = person(0.0);
  const PointCloud other = person(60.0);
  both.positions.insert(both.positions.end(), other.positions.begin(), other.positions.end());
  both.normals.insert(both.normals.end(), other.normals.begin(), other.normals.end());
  both.colors.insert(both.colors.end(), other.colors.begin(), other.colors.end());
  write(both);
  expect_framed({kPerson.min, kPerson.max + glm::dvec3(60.0, 0.0, 0.0)}, 0.01);
}

}  // namespace
}  // namespace pointreel::stage_view_test
