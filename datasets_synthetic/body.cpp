#include "datasets_synthetic/body.h"

#include <algorithm>
#include <cmath>

#include "datasets_synthetic/trigonometry.h"

namespace pointreel {
namespace {

struct Joint {
  Bone parent;
  glm::dvec3 rest;  // metres, with the figure at rest
};

// The proportions of an adult who is 1.76 m tall. The pelvis is the root and its own parent.
constexpr std::array<Joint, kBoneCount> kJoints = {{
    {Bone::pelvis, {0.0, 0.95, 0.0}},
    {Bone::pelvis, {0.0, 1.04, 0.0}},
    {Bone::abdomen, {0.0, 1.18, 0.0}},
    {Bone::chest, {0.0, 1.45, -0.01}},
    {Bone::neck, {0.0, 1.54, 0.005}},
    {Bone::chest, {0.185, 1.405, -0.01}},
    {Bone::left_upper_arm, {0.185, 1.115, -0.01}},
    {Bone::left_forearm, {0.185, 0.865, -0.01}},
    {Bone::chest, {-0.185, 1.405, -0.01}},
    {Bone::right_upper_arm, {-0.185, 1.115, -0.01}},
    {Bone::right_forearm, {-0.185, 0.865, -0.01}},
    {Bone::pelvis, {0.088, 0.93, 0.0}},
    {Bone::left_thigh, {0.088, 0.50, 0.0}},
    {Bone::left_shin, {0.088, 0.09, -0.01}},
    {Bone::left_foot, {0.095, 0.032, 0.12}},
    {Bone::pelvis, {-0.088, 0.93, 0.0}},
    {Bone::right_thigh, {-0.088, 0.50, 0.0}},
    {Bone::right_shin, {-0.088, 0.09, -0.01}},
    {Bone::right_foot, {-0.095, 0.032, 0.12}},
}};

constexpr std::size_t index(Bone bone) { return static_cast<std::size_t>(bone); }

/// Adds primitives, given in rest coordinates, to a body and joins them.
class Builder {
 public:
  explicit Builder(Body& body) : body_(body) {}

  std::uint16_t cone(Bone bone, Material material, const glm::dvec3& a, double radius_a,
                     const glm::dvec3& b, double radius_b) {
    return add(bone, material, RoundCone{place(bone, a), place(bone, b), radius_a, radius_b});
  }
  std::uint16_t ellipsoid(Bone bone, Material material, const glm::dvec3& center,
                          const glm::dvec3& radii, const Turn& turn = {}) {
    return add(
        bone, material,
        Ellipsoid{place(bone, center), body_.frames[index(bone)].axes * rotation(turn), radii});
  }
  std::uint16_t disc(Bone bone, Material material, const glm::dvec3& center, double radius,
                     double thickness, const Turn& tilt) {
    const glm::dvec3 axis = body_.frames[index(bone)].axes * rotation(tilt)[1];
    return add(bone, material, Disc{place(bone, center), axis, radius, thickness});
  }
  void blend(std::uint16_t first, std::uint16_t second, double radius) {
    body_.surface.blends.push_back({first, second, radius});
  }

 private:
  glm::dvec3 place(Bone bone, const glm::dvec3& rest) const {
    return body_.frames[index(bone)].place(rest);
  }
  std::uint16_t add(Bone bone, Material material, const Primitive& primitive) {
    body_.surface.primitives.push_back(primitive);
    body_.parts.push_back({bone, material});
    return static_cast<std::uint16_t>(body_.parts.size() - 1);
  }

  Body& body_;
};

/// A fold of cloth around a limb.
struct Fold {
  glm::dvec3 center;
  double radius;  ///< of its outer rim
  Turn tilt;
};

void add_fold(Builder& b, Bone bone, Material material, std::uint16_t around, const Fold& fold) {
  constexpr double kThickness = 0.0065;
  const auto disc =
      b.disc(bone, material, fold.center, fold.radius - kThickness, kThickness, fold.tilt);
  b.blend(around, disc, 0.014);
}

struct Trunk {
  std::uint16_t pelvis, abdomen, chest, shoulders;
};

/// Adds the hem of the shirt, its folds at the waist and below the armpits, and the collar.
void add_shirt(Builder& b, const Trunk& trunk) {
  const auto hem = b.ellipsoid(Bone::pelvis, Material::shirt, {0, 1.048, -0.003},
                               {0.149, 0.017, 0.109}, {0.04, 0.03, 0});
  b.blend(trunk.pelvis, hem, 0.008);
  b.blend(trunk.abdomen, hem, 0.02);
  struct Waist {
    glm::dvec3 center, radii;
    Turn tilt;
  };
  for (const Waist& fold : {Waist{{0, 1.098, 0}, {0.1465, 0.014, 0.1075}, {0.06, 0.16, 0}},
                            Waist{{0, 1.143, 0}, {0.1475, 0.013, 0.108}, {-0.08, -0.13, 0}},
                            Waist{{0, 1.192, -0.002}, {0.148, 0.013, 0.1075}, {0.1, 0.09, 0}}}) {
    b.blend(trunk.abdomen,
            b.ellipsoid(Bone::abdomen, Material::shirt, fold.center, fold.radii, fold.tilt), 0.014);
  }
  for (const double side : {1.0, -1.0}) {
    const auto front = b.cone(Bone::chest, Material::shirt, {side * 0.122, 1.355, 0.062}, 0.009,
                              {side * 0.045, 1.225, 0.0875}, 0.006);
    const auto back = b.cone(Bone::chest, Material::shirt, {side * 0.118, 1.36, -0.075}, 0.01,
                             {side * 0.075, 1.2, -0.087}, 0.007);
    b.blend(trunk.chest, front, 0.02);
    b.blend(trunk.chest, back, 0.022);
  }
  const auto collar =
      b.disc(Bone::chest, Material::trim, {0, 1.447, -0.012}, 0.064, 0.009, {0.2, 0, 0});
  b.blend(trunk.shoulders, collar, 0.012);
}

Trunk add_trunk(Builder& b) {
  const auto pelvis =
      b.ellipsoid(Bone::pelvis, Material::pelvis, {0, 0.975, -0.005}, {0.158, 0.115, 0.112});
  const auto abdomen =
      b.ellipsoid(Bone::abdomen, Material::shirt, {0, 1.13, 0.0}, {0.138, 0.14, 0.1});
  const auto chest =
      b.ellipsoid(Bone::chest, Material::shirt, {0, 1.305, -0.005}, {0.165, 0.165, 0.115});
  const auto shoulders = b.cone(Bone::chest, Material::shirt, {-0.15, 1.405, -0.012}, 0.052,
                                {0.15, 1.405, -0.012}, 0.052);
  b.blend(pelvis, abdomen, 0.06);
  b.blend(abdomen, chest, 0.06);
  b.blend(chest, shoulders, 0.05);

  const auto neck =
      b.cone(Bone::neck, Material::skin, {0, 1.43, -0.015}, 0.054, {0, 1.54, 0.005}, 0.05);
  const auto skull =
      b.ellipsoid(Bone::head, Material::head, {0, 1.645, 0.008}, {0.077, 0.108, 0.098});
  const auto jaw =
      b.ellipsoid(Bone::head, Material::head, {0, 1.588, 0.042}, {0.056, 0.062, 0.058});
  const auto nose =
      b.cone(Bone::head, Material::head, {0, 1.65, 0.1}, 0.008, {0, 1.62, 0.114}, 0.013);
  const auto hair =
      b.ellipsoid(Bone::head, Material::hair, {0, 1.668, -0.012}, {0.085, 0.097, 0.102});
  b.blend(shoulders, neck, 0.03);
  b.blend(neck, skull, 0.02);
  b.blend(neck, jaw, 0.02);
  b.blend(skull, jaw, 0.03);
  b.blend(skull, nose, 0.012);
  b.blend(skull, hair, 0.006);
  for (const double side : {1.0, -1.0}) {
    const auto ear =
        b.ellipsoid(Bone::head, Material::head, {side * 0.081, 1.628, 0.004}, {0.012, 0.032, 0.02});
    b.blend(skull, ear, 0.008);
  }
  return {pelvis, abdomen, chest, shoulders};
}

void add_arm(Builder& b, const Trunk& trunk, const Pose& pose, bool left) {
  const double side = left ? 1.0 : -1.0;
  const double x = side * 0.185, z = -0.01;
  const Bone upper_bone = left ? Bone::left_upper_arm : Bone::right_upper_arm;
  const Bone fore_bone = left ? Bone::left_forearm : Bone::right_forearm;
  const Bone hand_bone = left ? Bone::left_hand : Bone::right_hand;
  const auto upper =
      b.cone(upper_bone, Material::sleeve, {x, 1.405, z}, 0.053, {x, 1.115, z}, 0.041);
  const auto fore = b.cone(fore_bone, Material::skin, {x, 1.115, z}, 0.041, {x, 0.865, z}, 0.028);
  const auto palm = b.ellipsoid(hand_bone, Material::skin, {x, 0.81, z}, {0.018, 0.058, 0.042});
  const auto thumb = b.cone(hand_bone, Material::skin, {x - side * 0.004, 0.838, z + 0.03}, 0.0145,
                            {x - side * 0.012, 0.785, z + 0.058}, 0.011);
  b.blend(trunk.shoulders, upper, 0.03);
  b.blend(trunk.chest, upper, 0.035);
  b.blend(upper, fore, 0.02);
  b.blend(fore, palm, 0.02);
  b.blend(palm, thumb, 0.012);
  for (const Fold& fold : {Fold{{x, 1.237, z}, 0.0545, {0.06, side * 0.08, 0}},
                           Fold{{x, 1.288, z}, 0.0535, {0.3, side * -0.2, 0}},
                           Fold{{x, 1.34, z}, 0.0555, {-0.25, side * 0.25, 0}}}) {
    add_fold(b, upper_bone, Material::sleeve, upper, fold);
  }
  // Each finger has two bones, which curl towards the palm. They need no frames of their own.
  const double curl = pose.curl[left ? 0 : 1];
  const auto direction = [side](double angle) {  // an angle of 0 is along the palm
    return glm::dvec3(-side * sine(angle), -cosine(angle), 0.0);
  };
  constexpr std::array<double, 4> lengths = {0.058, 0.075, 0.081, 0.073};  // little finger first
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    const double across = z - 0.03 + 0.02 * static_cast<double>(i);
    const glm::dvec3 knuckle(x, i == 0 ? 0.775 : 0.77, across);
    const glm::dvec3 middle = knuckle + 0.55 * lengths[i] * direction(0.1 + 1.35 * curl);
    const glm::dvec3 tip = middle + 0.45 * lengths[i] * direction(0.2 + 3.0 * curl);
    const auto near = b.cone(hand_bone, Material::skin, knuckle, 0.0105, middle, 0.0095);
    const auto far = b.cone(hand_bone, Material::skin, middle, 0.0095, tip, 0.0085);
    b.blend(palm, near, 0.008);
    b.blend(near, far, 0.0);
  }
}

void add_leg(Builder& b, const Trunk& trunk, bool left) {
  const double side = left ? 1.0 : -1.0;
  const double x = side * 0.088, toe = side * 0.095;
  const Bone thigh_bone = left ? Bone::left_thigh : Bone::right_thigh;
  const Bone shin_bone = left ? Bone::left_shin : Bone::right_shin;
  const Bone foot_bone = left ? Bone::left_foot : Bone::right_foot;
  const Bone toes_bone = left ? Bone::left_toes : Bone::right_toes;
  const auto thigh =
      b.cone(thigh_bone, Material::trousers, {x, 0.93, 0}, 0.085, {x, 0.50, 0}, 0.056);
  const auto shin =
      b.cone(shin_bone, Material::trousers, {x, 0.50, 0}, 0.055, {x, 0.09, -0.01}, 0.037);
  const auto calf =
      b.ellipsoid(shin_bone, Material::trousers, {x, 0.36, -0.018}, {0.05, 0.12, 0.05});
  // The sole is level: at rest, each sphere of the foot touches the plane y = 0. Only the ankle has
  // a
  // fillet, because any other fillet would push the sole through the floor.
  const auto ankle =
      b.cone(foot_bone, Material::shoe, {x, 0.09, -0.01}, 0.036, {x, 0.075, 0.01}, 0.038);
  const auto foot =
      b.cone(foot_bone, Material::shoe, {x, 0.044, -0.045}, 0.044, {toe, 0.036, 0.12}, 0.036);
  const auto toes =
      b.cone(toes_bone, Material::shoe, {toe, 0.036, 0.12}, 0.036, {toe, 0.028, 0.175}, 0.028);
  b.blend(trunk.pelvis, thigh, 0.05);
  b.blend(thigh, shin, 0.025);
  b.blend(shin, calf, 0.03);
  b.blend(shin, ankle, 0.012);
  b.blend(ankle, foot, 0.02);
  b.blend(foot, toes, 0.0);
  for (const Fold& fold : {Fold{{x, 0.82, 0}, 0.0825, {0.4, side * 0.3, 0}},
                           Fold{{x, 0.555, 0}, 0.0645, {-0.3, side * 0.1, 0}}}) {
    add_fold(b, thigh_bone, Material::trousers, thigh, fold);
  }
  for (const Fold& fold : {Fold{{x, 0.45, 0}, 0.0595, {0.32, side * -0.12, 0}},
                           Fold{{x, 0.222, -0.007}, 0.051, {-0.2, side * 0.2, 0}},
                           Fold{{x, 0.172, -0.008}, 0.0505, {0.22, side * -0.1, 0}},
                           Fold{{x, 0.132, -0.009}, 0.0525, {-0.06, 0, 0}}}) {
    add_fold(b, shin_bone, Material::trousers, shin, fold);
  }
  const auto crease = b.cone(thigh_bone, Material::trousers, {x, 0.78, 0.071}, 0.008,
                             {x + side * 0.01, 0.6, 0.0595}, 0.006);
  b.blend(thigh, crease, 0.018);
}

Material material_of(Ball::Kind kind) {
  switch (kind) {
    case Ball::Kind::soccer:
      return Material::soccer_ball;
    case Ball::Kind::basketball:
      return Material::basketball;
    case Ball::Kind::baseball:
      break;
  }
  return Material::baseball;
}

void add_ball(Builder& b, const Ball& ball) {
  const auto all = b.cone(Bone::ball, material_of(ball.kind), {0, 0, 0}, radius(ball.kind),
                          {0, 0, 0}, radius(ball.kind));
  b.blend(all, all, 0.0);
}

void add_bat(Builder& b) {
  constexpr double kKnobHalf = 0.009;
  const auto knob = b.ellipsoid(Bone::bat, Material::bat, {0, kKnobHalf, 0}, {0.025, 0.009, 0.025});
  const auto handle = b.cone(Bone::bat, Material::bat, {0, 0.012, 0}, 0.0125, {0, 0.36, 0}, 0.0135);
  const auto taper = b.cone(Bone::bat, Material::bat, {0, 0.36, 0}, 0.0135, {0, 0.6, 0}, 0.031);
  const auto barrel = b.cone(Bone::bat, Material::bat, {0, 0.6, 0}, 0.031, {0, 0.807, 0}, 0.033);
  b.blend(knob, handle, 0.01);
  b.blend(handle, taper, 0.02);
  b.blend(taper, barrel, 0.03);
}

}  // namespace

glm::dmat3 rotation(const Turn& turn) {
  const double cx = cosine(turn.pitch), sx = sine(turn.pitch);
  const double cy = cosine(turn.twist), sy = sine(turn.twist);
  const double cz = cosine(turn.roll), sz = sine(turn.roll);
  const glm::dmat3 x(1, 0, 0, 0, cx, sx, 0, -sx, cx);  // columns
  const glm::dmat3 y(cy, 0, -sy, 0, 1, 0, sy, 0, cy);
  const glm::dmat3 z(cz, sz, 0, -sz, cz, 0, 0, 0, 1);
  return z * x * y;
}

double radius(Ball::Kind kind) {
  switch (kind) {
    case Ball::Kind::soccer:
      return 0.11;
    case Ball::Kind::basketball:
      return 0.12;
    case Ball::Kind::baseball:
      break;
  }
  return 0.037;
}

glm::dvec3 Body::in_rest(std::size_t primitive, const glm::dvec3& p) const {
  const Frame& frame = frames[index(parts[primitive].bone)];
  return frame.rest_joint + (p - frame.joint) * frame.axes;
}

Skeleton skeleton(const Pose& pose) {
  Skeleton frames;
  for (std::size_t i = 0; i < kBoneCount; ++i) {
    Frame& frame = frames[i];
    frame.rest_joint = kJoints[i].rest;
    const std::size_t parent = index(kJoints[i].parent);
    if (parent == i) {
      frame.joint = frame.rest_joint + pose.offset;
      frame.axes = pose.turns[i];
    } else {
      frame.joint = frames[parent].place(frame.rest_joint);
      frame.axes = frames[parent].axes * pose.turns[i];
    }
  }
  if (pose.ball) frames[index(Bone::ball)] = {pose.ball->axes, pose.ball->center, {}};
  if (pose.bat) frames[index(Bone::bat)] = {pose.bat->axes, pose.bat->knob, {}};
  return frames;
}

Body pose_body(const Pose& pose) {
  Body body;
  body.frames = skeleton(pose);
  Builder builder(body);
  const Trunk trunk = add_trunk(builder);
  add_shirt(builder, trunk);
  for (const bool left : {true, false}) {
    add_arm(builder, trunk, pose, left);
    add_leg(builder, trunk, left);
  }
  if (pose.ball) add_ball(builder, *pose.ball);
  if (pose.bat) add_bat(builder);
  return body;
}

void stand_on_floor(Pose& pose) {
  Pose alone = pose;
  alone.ball.reset();
  alone.bat.reset();
  Box box;
  for (const Primitive& primitive : pose_body(alone).surface.primitives) {
    box.grow(bounds(primitive));
  }
  pose.offset.y -= box.min.y;
}

}  // namespace pointreel
