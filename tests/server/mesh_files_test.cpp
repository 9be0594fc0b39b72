#include <cmath>
#include <cstdint>
#include <cstring>
#include <sstream>
#include <string>
#include <vector>

#include <glm/gtc/quaternion.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "codec/core/triangle_mesh.h"
#include "codec/files/glb_write.h"
#include "codec/files/obj_write.h"
#include "codec/files/ply.h"
#include "tests/read_file.h"
#include "tests/temporary_folder.h"

namespace pointreel::mesh_files_test {
namespace {

using nlohmann::json;

/// Two triangles of four vertices.
TriangleMesh leaf(float x = 0.0f) {
  TriangleMesh mesh;
  mesh.vertices.positions = {{x, 0, 0}, {x + 1, 0, 0}, {x + 1, 1, 0}, {x, 1, 0.5f}};
  mesh.vertices.normals.assign(4, glm::vec3(0, 0, 1));
  mesh.vertices.colors = {{65535, 0, 0}, {0, 65535, 0}, {0, 0, 65535}, {257 * 188, 0, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

std::string text_of(const Bytes& bytes) { return {bytes.begin(), bytes.end()}; }

TEST(MeshFiles, ply_holds_vertices_and_faces) {
  const TriangleMesh mesh = leaf();
  const Bytes bytes = ply_bytes(mesh.vertices, mesh.triangles);
  const std::string text = text_of(bytes);
  EXPECT_THAT(text, testing::HasSubstr("element vertex 4\n"));
  EXPECT_THAT(text, testing::HasSubstr(
                        "element face 2\nproperty list uchar uint vertex_indices\nend_header\n"));
  std::vector<std::uint8_t> last = {3, 0, 0, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0};
  EXPECT_TRUE(std::equal(last.rbegin(), last.rend(), bytes.rbegin()));
  const Result<PointCloud> read = read_ply(bytes);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->positions, mesh.vertices.positions);
  EXPECT_EQ(read->colors, mesh.vertices.colors);
}

TEST(MeshFiles, obj_holds_coordinates_colours_normals_and_faces) {
  TriangleMesh mesh = leaf();
  mesh.vertices.origin = glm::dvec3(4500000.125, 0.0, 0.0);
  std::istringstream lines(text_of(obj_bytes(mesh)));
  std::vector<std::string> all;
  for (std::string line; std::getline(lines, line);) all.push_back(line);
  ASSERT_EQ(all.size(), 10u);
  EXPECT_EQ(all[0], "v 4500000.125 0 0 1 0 0");
  EXPECT_EQ(all[3], "v 4500000.125 1 0.5 0.73725 0 0");
  EXPECT_EQ(all[4], "vn 0 0 1");
  EXPECT_EQ(all[9], "f 1//1 3//3 4//4");
}

/// A .glb file, taken apart as the specification says.
struct Glb {
  json document;
  std::string data;

  explicit Glb(const std::filesystem::path& path) {
    const std::string file = read_file(path);
    const auto word = [&](std::size_t at) {
      std::uint32_t value = 0;
      std::memcpy(&value, file.data() + at, sizeof(value));
      return value;
    };
    EXPECT_EQ(file.substr(0, 4), "glTF");
    EXPECT_EQ(word(4), 2u);
    EXPECT_EQ(word(8), file.size());
    EXPECT_EQ(file.substr(16, 4), "JSON");
    const std::uint32_t text = word(12);
    EXPECT_EQ(text % 4, 0u);
    document = json::parse(file.substr(20, text));
    if (20 + text == file.size()) return;
    EXPECT_EQ(file.substr(24 + text, 4), std::string("BIN\0", 4));
    data = file.substr(28 + text);
    EXPECT_EQ(word(20 + text), data.size());
  }

  /// The numbers of an accessor.
  template <class T>
  std::vector<T> values(const json& accessor) const {
    const json& about = document["accessors"][accessor.get<std::size_t>()];
    const json& view = document["bufferViews"][about["bufferView"].get<std::size_t>()];
    std::vector<T> values(view["byteLength"].get<std::size_t>() / sizeof(T));
    std::memcpy(values.data(), data.data() + view["byteOffset"].get<std::size_t>(),
                view["byteLength"].get<std::size_t>());
    return values;
  }

  /// The scale of a frame's node at a time, as players with the interpolation STEP see it.
  float scale(std::size_t frame, float time) const {
    const json& animation = document["animations"][0];
    const json& node = document["nodes"][frame + 1];
    float scale = node.contains("scale") ? node["scale"][0].get<float>() : 1.0f;
    for (const json& channel : animation["channels"]) {
      if (channel["target"]["node"] != frame + 1) continue;
      EXPECT_EQ(channel["target"]["path"], "scale");
      const json& sampler = animation["samplers"][channel["sampler"].get<std::size_t>()];
      EXPECT_EQ(sampler["interpolation"], "STEP");
      const auto times = values<float>(sampler["input"]), scales = values<float>(sampler["output"]);
      EXPECT_EQ(scales.size(), 3 * times.size());
      for (std::size_t i = 0; i < times.size(); ++i) {
        if (i == 0 || times[i] <= time) scale = scales[3 * i];
      }
    }
    return scale;
  }
};

TEST(MeshFiles, glb_holds_one_mesh) {
  const TemporaryFolder folder;
  TriangleMesh mesh = leaf();
  mesh.vertices.origin = glm::dvec3(1000.0, 2000.0, 3000.0);
  {
    GlbWriter writer(folder / "a.glb", "leaf", 'z');
    ASSERT_TRUE(writer.add(mesh, 0));
    ASSERT_TRUE(writer.finish(0));
  }
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
  const Glb glb(folder / "a.glb");
  EXPECT_FALSE(glb.document.contains("animations"));
  EXPECT_EQ(glb.document["nodes"][1]["translation"], json({1000.0, 2000.0, 3000.0}));
  EXPECT_NEAR(glb.document["nodes"][0]["rotation"][0].get<double>(), -std::sqrt(0.5), 1e-12);
  const json& primitive = glb.document["meshes"][0]["primitives"][0];
  const auto positions = glb.values<float>(primitive["attributes"]["POSITION"]);
  EXPECT_THAT(positions, testing::ElementsAre(0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0.5f));
  EXPECT_THAT(glb.values<std::uint32_t>(primitive["indices"]),
              testing::ElementsAre(0, 1, 2, 0, 2, 3));
  const auto colors = glb.values<std::uint16_t>(primitive["attributes"]["COLOR_0"]);
  ASSERT_EQ(colors.size(), 16u);
  EXPECT_EQ(colors[0], 65535);
  EXPECT_NEAR(colors[12] / 65535.0, 0.5029, 1e-3) << "188 of 255 in sRGB";
  const json& box = glb.document["accessors"][primitive["attributes"]["POSITION"].get<int>()];
  EXPECT_EQ(box["max"], json({1.0, 1.0, 0.5}));
}

TEST(MeshFiles, glb_points_up_along_y) {
  const TemporaryFolder folder;
  for (const char* name : {"x", "-x", "y", "-y", "z", "-z"}) {
    const Up up = *parse_up(name);
    {
      GlbWriter writer(folder / "a.glb", "leaf", up);
      ASSERT_TRUE(writer.add(leaf(), 0));
      ASSERT_TRUE(writer.finish(0));
    }
    const json root = Glb(folder / "a.glb").document["nodes"][0];
    const auto turn = root.value("rotation", std::vector<double>{0, 0, 0, 1});
    const glm::dquat by(turn[3], turn[0], turn[1], turn[2]);
    EXPECT_LT(glm::distance(by * up.direction(), glm::dvec3(0, 1, 0)), 1e-12) << name;
  }
}

TEST(MeshFiles, glb_shows_each_frame_at_its_time) {
  const TemporaryFolder folder;
  GlbWriter writer(folder / "a.glb", "leaves", 'y');
  const std::vector<std::uint64_t> times = {7'000'000, 7'100'000, 7'100'000, 7'300'000};
  for (std::size_t i = 0; i < times.size(); ++i)
    ASSERT_TRUE(writer.add(i == 3 ? TriangleMesh{} : leaf(static_cast<float>(i)), times[i]));
  ASSERT_TRUE(writer.finish(7'400'000));
  const Glb glb(folder / "a.glb");
  const std::vector<std::pair<float, std::size_t>> shown = {{0.0f, 0},  {0.09f, 0}, {0.11f, 2},
                                                            {0.29f, 2}, {0.31f, 3}, {0.4f, 3}};
  for (const auto& [time, frame] : shown) {
    for (std::size_t i = 0; i < 4; ++i)
      EXPECT_EQ(glb.scale(i, time), i == frame ? 1.0f : 0.0f) << "frame " << i << " at " << time;
  }
  EXPECT_FALSE(glb.document["nodes"][4].contains("mesh")) << "the last frame is empty";
  EXPECT_FALSE(glb.document["nodes"][1].contains("scale"));
  EXPECT_EQ(glb.document["nodes"][2]["scale"], json({0, 0, 0}));
}

TEST(MeshFiles, glb_of_nothing_is_an_empty_scene) {
  const TemporaryFolder folder;
  GlbWriter writer(folder / "a.glb", "nothing", 'y');
  ASSERT_TRUE(writer.add({}, 0));
  ASSERT_TRUE(writer.finish(0));
  const Glb glb(folder / "a.glb");
  EXPECT_FALSE(glb.document.contains("meshes"));
  EXPECT_FALSE(glb.document.contains("buffers"));
}

TEST(MeshFiles, a_folder_that_does_not_exist_is_an_error_that_names_the_file) {
  GlbWriter writer("/no such folder/a.glb", "leaf", 'y');
  const Result<void> added = writer.add(leaf(), 0);
  ASSERT_FALSE(added);
  EXPECT_EQ(added.error().code, ErrorCode::io);
  EXPECT_THAT(added.error().message, testing::StartsWith("/no such folder/a.glb: "));
}

}  // namespace
}  // namespace pointreel::mesh_files_test
