#include <limits>
#include <utility>

#include "datasets_synthetic/random.h"
#include "datasets_synthetic/trigonometry.h"
#include "pointreel/draco.h"
#include "tests/golden/streams.h"

namespace pointreel::golden {
namespace {

constexpr Cube kCube{glm::dvec3(-3.0, 1e6, 0.25), 2.0};

/// A bumpy ball in the middle of the cube, with waves of colour and normals that point outward. In
/// a small ball, some cells of level 7 are divided further.
PointCloud ball(int points, float radius = 0.03f) {
  Random random(1, 0);
  PointCloud cloud;
  cloud.origin = kCube.origin;
  for (int i = 0; i < points; ++i) {
    // In a loop, because compilers may evaluate the arguments of a constructor in any order.
    glm::vec3 d;
    for (int axis = 0; axis < 3; ++axis) d[axis] = static_cast<float>(random.normal());
    d = glm::normalize(d);
    const auto bump = static_cast<float>(1.0 + 0.1 * sine(5.0 * d.x));
    cloud.positions.push_back(1.0f + d * (radius * bump));
    cloud.normals.push_back(d);
    const glm::vec3 wave(static_cast<float>(sine(4.0 * d.x)), static_cast<float>(sine(7.0 * d.y)),
                         static_cast<float>(sine(9.0 * d.z)));
    cloud.colors.push_back(glm::u16vec3((wave * 0.4f + 0.5f) * 255.0f) * std::uint16_t{257});
  }
  return cloud;
}

/// All voxels of a ball in a grid of 2^bits cells along each side.
PointCloud solid(int bits) {
  const int side = 1 << bits;
  const float cell = 2.0f / static_cast<float>(side);
  PointCloud cloud;
  cloud.origin = kCube.origin;
  for (int z = 0; z < side; ++z) {
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        const glm::vec3 p = (glm::vec3(x, y, z) + 0.5f) * cell;
        if (glm::length(p - 1.0f) > 0.8f) continue;
        cloud.positions.push_back(p);
        cloud.normals.push_back(glm::vec3(0, 0, 1));
        cloud.colors.push_back(glm::u16vec3(255 * x / side, 255 * y / side, 255 * z / side) *
                               std::uint16_t{257});
      }
    }
  }
  return cloud;
}

/// Two bent sheets, large enough for slabs: upright, or lying flat.
PointCloud sheets(bool lying) {
  PointCloud cloud;
  cloud.origin = kCube.origin;
  for (int i = 0; i < 128; ++i) {
    for (int j = 0; j < 90; ++j) {
      for (const int sheet : {20, 80}) {
        const int x = sheet + (i * i + i * j) / 1000;
        const glm::vec3 p = lying ? glm::vec3(x, j, i) : glm::vec3(x, i, j);
        cloud.positions.push_back((p + 0.25f) / 64.0f);
      }
    }
  }
  return cloud;
}

PointCloud with_16_bit_colors(PointCloud cloud) {
  Random random(3, 0);
  for (glm::u16vec3& color : cloud.colors) {
    for (int i = 0; i < 3; ++i) color[i] = static_cast<std::uint16_t>(color[i] + random.below(257));
  }
  return cloud;
}

/// Makes every third normal unknown, and all of them near the top.
PointCloud with_unknown_normals(PointCloud cloud) {
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (i % 3 == 0 || cloud.positions[i].y > 1.02f) cloud.normals[i] = glm::vec3(0.0f);
  }
  return cloud;
}

/// A smooth field, labels, and one that is unknown for some points.
PointCloud with_scalars(PointCloud cloud) {
  cloud.scalars = {{"height", {}}, {"class", {}}, {"patchy", {}}};
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::vec3 p = cloud.positions[i];
    cloud.scalars[0].values.push_back(static_cast<float>(sine(9.0 * p.x)) + p.y);
    cloud.scalars[1].values.push_back(p.x < 0.99f ? 2.0f : p.y < 1.0f ? 6.0f : 9.0f);
    cloud.scalars[2].values.push_back(p.z < 1.0f ? std::numeric_limits<float>::quiet_NaN()
                                                 : 1000.0f * p.x);
  }
  return cloud;
}

PointCloud positions(const PointCloud& cloud) {
  PointCloud bare;
  bare.origin = cloud.origin;
  bare.positions = cloud.positions;
  return bare;
}

/// The qualities are given here, so that streams do not depend on what the defaults are.
OctreeOptions octree(Entropy entropy, int depth, int colors = 50, int normals = 43) {
  OctreeOptions options;
  options.entropy = entropy;
  options.depth = DepthRule::fixed(depth);
  options.color_quality = colors;
  options.normal_quality = normals;
  return options;
}

DracoOptions draco(int bits, int level, DracoMethod method = DracoMethod::automatic) {
  DracoOptions options;
  options.method = method;
  options.position_bits = bits;
  options.compression_level = level;
  return options;
}

struct Recipe {
  std::string name;
  PointCloud cloud;
  EncodeOptions options;
};

std::vector<Recipe> octree_recipes() {
  std::vector<Recipe> recipes;
  const auto add = [&](std::string name, PointCloud cloud, const OctreeOptions& options) {
    recipes.push_back({std::move(name), std::move(cloud), {options}});
  };
  for (const Entropy entropy : {Entropy::none, Entropy::zstd, Entropy::context}) {
    const std::string coding = pointreel::name(entropy);
    add(coding + "_empty", {}, octree(entropy, 8));
    add(coding + "_one_point", ball(1), octree(entropy, 0));
    add(coding + "_one_point_depth_21", ball(1), octree(entropy, 21));
    add(coding + "_one_layer", ball(150, 0.8f), octree(entropy, 6));
    add(coding + "_two_layers", ball(150), octree(entropy, 8));
    add(coding + "_three_layers", ball(150), octree(entropy, 11));
    add(coding + "_positions", positions(ball(400, 0.8f)), octree(entropy, 10));
    add(coding + "_dense", positions(solid(5)), octree(entropy, 5));
    add(coding + "_lossless", ball(120), octree(entropy, 10, 100, 100));
  }
  const auto with = [&](const char* name, PointCloud cloud, int depth, int colors, int normals) {
    add(name, std::move(cloud), octree(Entropy::context, depth, colors, normals));
  };
  const PointCloud small = ball(120), plain = solid(4);
  with("lossless_16_bits", with_16_bit_colors(small), 10, 100, 100);
  with("lossless_unknown_normals", with_unknown_normals(small), 10, 100, 100);
  with("lossless_colors_only", small, 9, 100, 20);
  with("unknown_normals", with_unknown_normals(small), 10, 50, 43);
  with("colors_of_16_bits_lossy", with_16_bit_colors(small), 10, 90, 43);
  with("quality_1", small, 10, 1, 1);
  with("quality_99", small, 10, 99, 99);
  with("dense_quality_30", plain, 4, 30, 30);
  with("dense_quality_80", plain, 4, 80, 80);
  PointCloud same = small;
  same.positions.assign(same.size(), glm::vec3(0.7f));
  with("all_in_one_cell", same, 12, 50, 43);
  add("scalars_one_layer", with_scalars(ball(150, 0.8f)), octree(Entropy::context, 6));
  add("scalars_three_layers", with_scalars(ball(150)), octree(Entropy::context, 11));
  PointCloud alone = with_scalars(positions(ball(400, 0.8f)));
  alone.scalars.resize(1);
  add("scalars_alone", std::move(alone), octree(Entropy::zstd, 9));
  OctreeOptions slabs = octree(Entropy::context, 8);
  slabs.slabs = 4;
  add("slabs", sheets(false), slabs);
  slabs.slabs = 2;
  slabs.depth = DepthRule::fixed(10);
  add("slabs_of_two_layers", sheets(true), slabs);
  return recipes;
}

std::vector<Recipe> draco_recipes() {
  const PointCloud small = ball(120);
  return {{"draco_empty", {}, {draco(10, 7)}},
          {"draco_one_point", ball(1), {draco(10, 7)}},
          {"draco_positions", positions(ball(400, 0.8f)), {draco(11, 7)}},
          {"draco_level_1", small, {draco(11, 1)}},
          {"draco_level_10", small, {draco(11, 10)}},
          {"draco_level_0", small, {draco(11, 0)}},
          {"draco_sequential_1", small, {draco(11, 1, DracoMethod::sequential)}},
          {"draco_sequential_10", small, {draco(11, 10, DracoMethod::sequential)}},
          {"draco_sequential_16_bits",
           with_16_bit_colors(small),
           {draco(14, 7, DracoMethod::sequential)}},
          {"draco_sequential_unknown_normals",
           with_unknown_normals(small),
           {draco(10, 7, DracoMethod::sequential)}},
          {"draco_sequential_positions",
           positions(ball(400, 0.8f)),
           {draco(11, 7, DracoMethod::sequential)}},
          {"draco_16_bits", with_16_bit_colors(small), {draco(14, 7)}},
          {"draco_unknown_normals", with_unknown_normals(small), {draco(10, 7)}}};
}

}  // namespace

Result<std::vector<Stream>> good_streams() {
  std::vector<Recipe> recipes = octree_recipes();
  for (Recipe& recipe : draco_recipes()) recipes.push_back(std::move(recipe));
  std::vector<Stream> streams;
  for (const Recipe& recipe : recipes) {
    auto frame = encode_frame(recipe.cloud, kCube, recipe.options);
    if (!frame) return fail_at(recipe.name, frame.error());
    streams.push_back({recipe.name, std::move(*frame)});
  }
  return streams;
}

}  // namespace pointreel::golden
