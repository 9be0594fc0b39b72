#include "datasets_synthetic/body.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <tuple>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include "datasets_synthetic/motion.h"
#include "datasets_synthetic/samplers/uniform.h"
#include "datasets_synthetic/sequences.h"
#include "datasets_synthetic/trigonometry.h"

namespace pointreel::body_test {
namespace {

Box sampled_bounds(const Body& body) {
  Box box;
  const auto points = sample_uniform(body.surface, 12000, 5);
  for (const SurfacePoint& point : points.value()) box.grow(point.position);
  return box;
}

TEST(Body, is_as_tall_as_a_person_and_stands_on_the_floor_in_its_rest_pose) {
  const Box box = sampled_bounds(pose_body(Pose{}));
  EXPECT_GT(box.max.y, 1.70);
  EXPECT_LT(box.max.y, 1.80);
  EXPECT_NEAR(box.min.y, 0.0, 0.001);
  EXPECT_GE(box.min.y, -1e-6);
  EXPECT_NEAR(box.extent().x, 0.48, 0.06);  // the arms hang down
  EXPECT_NEAR(box.extent().z, 0.29, 0.06);  // the feet
}

TEST(Body, stands_on_the_floor_and_keeps_its_size_throughout_the_walk) {
  for (double time = 0.0; time < 2.0; time += 0.2) {
    const Box box = sampled_bounds(pose_body(walk(time)));
    EXPECT_NEAR(box.min.y, 0.0, 0.004) << time;
    EXPECT_GT(box.min.y, -1e-4) << time;
    EXPECT_GT(box.max.y, 1.6) << time;
    EXPECT_LT(box.max.y, 1.9) << time;
    EXPECT_LT(box.extent().x, 1.1) << time;
    EXPECT_LT(box.extent().z, 1.1) << time;
  }
}

TEST(Body, faces_positive_z_with_its_left_side_at_positive_x) {
  const Body body = pose_body(Pose{});
  const auto colour = [&](const glm::dvec3& from, const glm::dvec3& direction) {
    glm::dvec3 p = from;  // sphere tracing
    SurfaceDistance at = distance_to(body.surface, p);
    for (int i = 0; i < 200 && at.distance.value > 1e-6; ++i) {
      p += at.distance.value * direction;
      at = distance_to(body.surface, p);
    }
    EXPECT_LT(at.distance.value, 1e-5);
    return color_at(body, at.primitive, p);
  };
  const glm::u8vec3 disc = colour({0.075, 1.33, 1.0}, {0, 0, -1});
  EXPECT_GT(disc.r, 200);
  EXPECT_LT(disc.b, 90);
  const glm::u8vec3 plain = colour({-0.075, 1.33, 1.0}, {0, 0, -1});
  EXPECT_GT(plain.b, plain.r);
  const glm::u8vec3 left_sleeve = colour({1.0, 1.33, 0.0}, {-1, 0, 0});
  EXPECT_GT(left_sleeve.r, 2 * left_sleeve.b);
  const glm::u8vec3 right_sleeve = colour({-1.0, 1.33, 0.0}, {1, 0, 0});
  EXPECT_GT(right_sleeve.b, 2 * right_sleeve.r);
  const glm::u8vec3 cheek = colour({0.03, 1.615, 1.0}, {0, 0, -1});
  EXPECT_GT(cheek.r, 200);
  const glm::u8vec3 back_of_head = colour({0.03, 1.66, -1.0}, {0, 0, 1});
  EXPECT_LT(back_of_head.r, 100);
  const glm::u8vec3 left_shoe = colour({0.09, 0.05, 1.0}, {0, 0, -1});
  EXPECT_GT(left_shoe.r, 100);
  const glm::u8vec3 right_shoe = colour({-0.09, 0.05, 1.0}, {0, 0, -1});
  EXPECT_LT(right_shoe.r, 60);
}

TEST(Body, a_point_that_moves_with_its_bone_keeps_its_place_in_the_rest_pose) {
  const Body rest = pose_body(Pose{});
  const Body moved = pose_body(walk(1.0));
  ASSERT_EQ(rest.surface.primitives.size(), moved.surface.primitives.size());
  for (std::size_t i = 0; i < rest.surface.primitives.size(); ++i) {
    const auto center = [&](const Body& body) {
      const Primitive& primitive = body.surface.primitives[i];
      if (const auto* cone = std::get_if<RoundCone>(&primitive)) return body.in_rest(i, cone->a);
      if (const auto* disc = std::get_if<Disc>(&primitive)) return body.in_rest(i, disc->center);
      return body.in_rest(i, std::get<Ellipsoid>(primitive).center);
    };
    EXPECT_LT(glm::length(center(rest) - center(moved)), 1e-9) << i;
  }
}

TEST(Body, places_the_ball_by_the_pose_and_does_not_stand_on_it) {
  Pose pose;
  for (const auto kind : {Ball::Kind::soccer, Ball::Kind::basketball, Ball::Kind::baseball}) {
    pose.ball = Ball{kind, {0.5, -1.0, 0.3}, rotation({0.3, 0.2, 0.1})};
    stand_on_floor(pose);
    EXPECT_NEAR(pose.offset.y, 0.0, 1e-9);
    const Body body = pose_body(pose);
    const glm::dvec3 top = pose.ball->center + glm::dvec3(0, radius(kind), 0);
    const SurfaceDistance at = distance_to(body.surface, top);
    EXPECT_NEAR(at.distance.value, 0.0, 1e-9);
    EXPECT_EQ(body.parts[at.primitive].bone, Bone::ball);
    std::set<std::tuple<int, int, int>> colours;
    const auto points = sample_uniform(body.surface, 20000, 5);
    for (const SurfacePoint& point : points.value()) {
      if (point.primitive != at.primitive) continue;
      const glm::u8vec3 c = color_at(body, point.primitive, point.position);
      colours.emplace(c.x, c.y, c.z);
    }
    EXPECT_GE(colours.size(), 2u);
  }
}

TEST(Body, shows_a_bat_along_its_axis) {
  Pose pose;
  pose.bat = Bat{{0.5, 1.0, 0.3}, rotation({0.3, 0.2, 0.1})};
  const Body body = pose_body(pose);
  const SurfaceDistance knob = distance_to(body.surface, pose.bat->knob);
  EXPECT_NEAR(knob.distance.value, 0.0, 0.004);  // on the fillet
  EXPECT_EQ(body.parts[knob.primitive].bone, Bone::bat);
  const glm::dvec3 end = pose.bat->knob + 0.84 * pose.bat->axes[1];
  EXPECT_NEAR(distance_to(body.surface, end).distance.value, 0.0, 1e-6);
}

TEST(Body, is_lifted_by_its_offset_and_set_down_by_stand_on_floor) {
  Pose pose = walk(0.3);
  pose.offset += glm::dvec3(0.1, 0.3, -0.2);
  const Box jumping = sampled_bounds(pose_body(pose));
  EXPECT_NEAR(jumping.min.y, 0.3, 0.004);
  stand_on_floor(pose);
  EXPECT_NEAR(pose.offset.y, walk(0.3).offset.y, 1e-9);
}

TEST(Body, is_a_single_closed_surface) {
  const Body body = pose_body(walk(1.0));
  std::vector<std::size_t> piece(body.surface.primitives.size());
  for (std::size_t i = 0; i < piece.size(); ++i) piece[i] = i;
  for (std::size_t round = 0; round < piece.size(); ++round) {
    for (const Blend& blend : body.surface.blends) {
      piece[blend.first] = piece[blend.second] = std::min(piece[blend.first], piece[blend.second]);
    }
  }
  EXPECT_EQ(std::set<std::size_t>(piece.begin(), piece.end()).size(), 1u);
  for (const Blend& blend : body.surface.blends) {
    // Two joined parts overlap: both distances are negative somewhere.
    const auto depth = [&](const glm::dvec3& p) {
      return std::max(distance_to(body.surface.primitives[blend.first], p).value,
                      distance_to(body.surface.primitives[blend.second], p).value);
    };
    double deepest = std::numeric_limits<double>::infinity();
    const Box box = bounds(body.surface.primitives[blend.second]);
    for (int i = 0; i < 20 * 20 * 20; ++i) {
      const glm::dvec3 part(i % 20, i / 20 % 20, i / 400);
      deepest = std::min(deepest, depth(box.min + (part + 0.5) / 20.0 * box.extent()));
    }
    if (const auto* disc = std::get_if<Disc>(&body.surface.primitives[blend.second])) {
      const glm::dvec3 x = glm::normalize(glm::cross(disc->axis, glm::dvec3(0.3, 0.2, 1.0)));
      const glm::dvec3 z = glm::cross(x, disc->axis);
      for (int i = 0; i < 64; ++i) {
        const glm::dvec3 out = std::cos(0.1 * i) * x + std::sin(0.1 * i) * z;
        deepest =
            std::min(deepest, depth(disc->center + (disc->radius - 0.9 * disc->thickness) * out));
      }
    }
    EXPECT_LT(deepest, 0.0) << blend.first << " and " << blend.second;
  }
}

TEST(Motion, loops_without_a_jump_and_moves_in_between) {
  for (const Motion& motion : motions()) {
    if (!motion.loops) continue;
    const auto place = [&](double time, Bone bone) {
      return pose_body(motion.pose(time)).frames[static_cast<std::size_t>(bone)].joint;
    };
    for (const Bone bone : {Bone::left_hand, Bone::right_hand, Bone::left_foot, Bone::head}) {
      const glm::dvec3 start = place(0.0, bone);
      EXPECT_LT(glm::length(place(motion.seconds(), bone) - start), 1e-9);
      EXPECT_LT(glm::length(place(motion.seconds() - 1e-3, bone) - start), 0.02);
      double moved = 0.0;
      for (int i = 1; i < 60; ++i) {
        const double time = motion.seconds() * i / 60.0;
        moved = std::max(moved, glm::length(place(time, bone) - start));
        // No joint of a walking person is faster than 10 m/s.
        EXPECT_LT(glm::length(place(time, bone) - place(time - 1e-3, bone)), 0.01) << time;
      }
      EXPECT_GT(moved, bone == Bone::head ? 0.01 : 0.2);
    }
  }
}

TEST(Motion, is_found_by_its_name) {
  ASSERT_NE(find_motion("walk"), nullptr);
  EXPECT_EQ(find_motion("walk")->name, "walk");
  EXPECT_EQ(find_motion("wal"), nullptr);
}

TEST(Trigonometry, agrees_with_the_standard_library) {
  for (double angle = -20.0; angle < 20.0; angle += 0.0137) {
    EXPECT_NEAR(sine(angle), std::sin(angle), 1e-11) << angle;
    EXPECT_NEAR(cosine(angle), std::cos(angle), 1e-11) << angle;
  }
}

TEST(Sequence, frames_have_the_requested_points_and_attributes) {
  SequenceOptions options;
  options.sampler = Sampler::uniform;
  options.points = 5000;
  const auto frame = sequence_frame(*find_motion("walk"), options, 7);
  ASSERT_TRUE(frame) << frame.error().message;
  EXPECT_EQ(frame->size(), 5000u);
  EXPECT_EQ(frame->normals.size(), 5000u);
  EXPECT_EQ(frame->colors.size(), 5000u);
  EXPECT_TRUE(colors_fit_8_bits(*frame));
  std::set<std::tuple<int, int, int>> colours;
  for (const glm::u16vec3& c : frame->colors) colours.emplace(c.x, c.y, c.z);
  EXPECT_GE(colours.size(), 8u);
}

TEST(Sequence, noise_displaces_points_by_its_deviation_and_changes_nothing_else) {
  SequenceOptions options;
  options.sampler = Sampler::uniform;
  options.points = 20000;
  const auto clean = sequence_frame(*find_motion("walk"), options, 3);
  options.noise = 0.004;
  const auto noisy = sequence_frame(*find_motion("walk"), options, 3);
  ASSERT_TRUE(clean && noisy);
  EXPECT_EQ(clean->colors, noisy->colors);
  EXPECT_EQ(clean->normals, noisy->normals);
  glm::dvec3 sum(0.0), squares(0.0);
  for (std::size_t i = 0; i < clean->size(); ++i) {
    const glm::dvec3 d(noisy->positions[i] - clean->positions[i]);
    sum += d;
    squares += d * d;
  }
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(sum[axis] / 20000.0, 0.0, 0.00015);
    EXPECT_NEAR(std::sqrt(squares[axis] / 20000.0), 0.004, 0.0001);
  }
}

TEST(Sequence, frames_and_seeds_differ) {
  SequenceOptions options;
  options.sampler = Sampler::uniform;
  options.points = 1000;
  const Motion& motion = *find_motion("walk");
  const auto first = sequence_frame(motion, options, 0);
  EXPECT_EQ(first->positions, sequence_frame(motion, options, 0)->positions);
  EXPECT_NE(first->positions, sequence_frame(motion, options, 1)->positions);
  options.seed = 2;
  EXPECT_NE(first->positions, sequence_frame(motion, options, 0)->positions);
}

}  // namespace
}  // namespace pointreel::body_test
