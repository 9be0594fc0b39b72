#include "codec/files/gltf.h"

#include <cstring>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace pointreel::gltf_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

Result<PointCloud> read(const std::string& bytes, std::vector<std::string>* unread = nullptr,
                        const DecodeLimits& limits = {}) {
  ReadNotes notes;
  const ByteView view(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  const Result<PointCloud> cloud = read_gltf(ByteSource(view), limits, notes);
  if (unread != nullptr) *unread = notes.unread;
  return cloud;
}

std::string error_of(const std::string& bytes) {
  const Result<PointCloud> cloud = read(bytes);
  return cloud ? "it was read" : cloud.error().message;
}

template <class T>
void put(std::string& out, T value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

/// Two vertices with normals, and colours of 16 bits.
std::string data() {
  std::string bytes;
  for (const float v : {1.f, 2.f, 3.f, 4.f, 5.f, 6.f}) put(bytes, v);
  for (const float v : {0.f, 0.f, 1.f, 1.f, 0.f, 0.f}) put(bytes, v);
  for (const int v : {65535, 0, 0, 65535, 0, 14026, 65535, 0})
    put(bytes, static_cast<std::uint16_t>(v));
  return bytes;
}

const std::string kJson =
    R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],)"
    R"("nodes":[{"children":[1],"translation":[10,0,0]},{"mesh":0,"scale":[2,2,2]}],)"
    R"("meshes":[{"primitives":[{"mode":0,"attributes":{"POSITION":0,"NORMAL":1,"COLOR_0":2}}]}],)"
    R"("accessors":[{"bufferView":0,"componentType":5126,"count":2,"type":"VEC3"},)"
    R"({"bufferView":1,"componentType":5126,"count":2,"type":"VEC3"},)"
    R"({"bufferView":2,"componentType":5123,"count":2,"type":"VEC4","normalized":true}],)"
    R"("bufferViews":[{"buffer":0,"byteLength":24},{"buffer":0,"byteOffset":24,"byteLength":24},)"
    R"({"buffer":0,"byteOffset":48,"byteLength":16}],"buffers":[{"byteLength":64}],)"
    R"("textures":[{}]})";

std::string glb(std::string json, const std::string& binary = data()) {
  while (json.size() % 4 != 0) json += ' ';
  std::string out = "glTF";
  put(out, std::uint32_t{2});
  put(out, static_cast<std::uint32_t>(28 + json.size() + binary.size()));
  put(out, static_cast<std::uint32_t>(json.size()));
  out += "JSON" + json;
  put(out, static_cast<std::uint32_t>(binary.size()));
  out += std::string("BIN\0", 4) + binary;
  return out;
}

std::string changed(const std::string& from, const std::string& to) {
  std::string json = kJson;
  return glb(json.replace(json.find(from), from.size(), to));
}

TEST(Gltf, vertices_are_where_the_nodes_put_them) {
  std::vector<std::string> unread;
  const Result<PointCloud> cloud = read(glb(kJson), &unread);
  ASSERT_TRUE(cloud) << cloud.error().message;
  ASSERT_EQ(cloud->size(), 2u);
  EXPECT_EQ(cloud->world(0), glm::dvec3(12, 4, 6));
  EXPECT_EQ(cloud->world(1), glm::dvec3(18, 10, 12));
  EXPECT_THAT(cloud->normals, ElementsAre(glm::vec3(0, 0, 0.5f), glm::vec3(0.5f, 0, 0)));
  EXPECT_EQ(cloud->colors[0], glm::u16vec3(65535, 0, 0));
  EXPECT_NEAR(cloud->colors[1].y, 0.5 * 65535, 40);  // 0.214 is half as bright to the eye
  EXPECT_THAT(unread, ElementsAre("textures"));
}

TEST(Gltf, buffers_may_be_in_the_json) {
  std::string json = kJson;
  // 1, 2 and 3 as floats.
  json.replace(
      json.find(R"({"byteLength":64})"), 17,
      R"({"byteLength":12,"uri":"data:application/octet-stream;base64,AACAPwAAAEAAAEBA"})");
  json.replace(json.find(R"("byteLength":24)"), 15, R"("byteLength":12)");
  json.replace(json.find(R"("count":2)"), 9, R"("count":1)");
  json.replace(json.find(R"(,"NORMAL":1,"COLOR_0":2)"), 23, "");
  const Result<PointCloud> cloud = read(json);
  ASSERT_TRUE(cloud) << cloud.error().message;
  EXPECT_EQ(cloud->world(0), glm::dvec3(12, 4, 6));
}

TEST(Gltf, a_file_without_scenes_shows_all_roots) {
  const Result<PointCloud> cloud = read(changed(R"("scene":0,"scenes":[{"nodes":[0]}],)", ""));
  ASSERT_TRUE(cloud) << cloud.error().message;
  EXPECT_EQ(cloud->size(), 2u);
}

TEST(Gltf, sparse_accessors_change_single_vertices) {
  const Result<PointCloud> cloud = read(changed(
      R"("count":2,"type":"VEC3"})",
      R"("count":2,"type":"VEC3","sparse":{"count":1,"indices":{"bufferView":2,"byteOffset":2,)"
      R"("componentType":5121},"values":{"bufferView":1}}})"));
  ASSERT_TRUE(cloud) << cloud.error().message;
  EXPECT_EQ(cloud->world(0), glm::dvec3(10, 0, 2));
  EXPECT_EQ(cloud->world(1), glm::dvec3(18, 10, 12));
}

/// Two primitives: the vertices of kJson with colours, and one without, of the given material.
std::string floor_of(const std::string& material) {
  std::string json = kJson;
  json.replace(json.find(R"("COLOR_0":2}}])"), 14,
               R"("COLOR_0":2}},{"mode":0,"attributes":{"POSITION":1},"material":0}])");
  json.replace(json.find(R"("textures":[{}])"), 15, R"("materials":[)" + material + "]");
  return glb(json);
}

TEST(Gltf, primitives_without_colors_have_the_base_color_of_their_material) {
  const auto color = [](const std::string& material) {
    const Result<PointCloud> cloud = read(floor_of(material));
    EXPECT_TRUE(cloud && cloud->colors.size() == 4 &&
                cloud->colors[0] == glm::u16vec3(65535, 0, 0));
    return cloud ? cloud->colors.back() : glm::u16vec3(0);
  };
  EXPECT_EQ(color("{}"), glm::u16vec3(65535));
  const glm::u16vec3 red =
      color(R"({"pbrMetallicRoughness":{"baseColorFactor":[1,0,0.2140411,1]}})");
  EXPECT_EQ(glm::u16vec2(red), glm::u16vec2(65535, 0));
  EXPECT_NEAR(red.z, 0.5 * 65535, 40);
}

TEST(Gltf, base_colors_tint_the_colors_of_vertices_and_are_colors_themselves) {
  std::string json = kJson;
  json.replace(json.find(R"("mode":0)"), 8, R"("mode":0,"material":0)");
  json.replace(json.find(R"("textures":[{}])"), 15,
               R"("materials":[{"pbrMetallicRoughness":{"baseColorFactor":[0,1,1,1]}}])");
  const Result<PointCloud> tinted = read(glb(json));
  ASSERT_TRUE(tinted) << tinted.error().message;
  EXPECT_EQ(tinted->colors[0], glm::u16vec3(0));
  json.replace(json.find(R"(,"COLOR_0":2)"), 12, "");
  const Result<PointCloud> plain = read(glb(json));
  ASSERT_TRUE(plain) << plain.error().message;
  EXPECT_THAT(plain->colors,
              ElementsAre(glm::u16vec3(0, 65535, 65535), glm::u16vec3(0, 65535, 65535)));
  json.replace(json.find("[0,1,1,1]"), 9, "[1,1,1,1]");
  EXPECT_FALSE(read(glb(json)).value().has_colors());
}

TEST(Gltf, chunks_may_lack_padding) {
  std::string json = kJson;
  while (json.size() % 4 != 1) json += ' ';
  std::string out = "glTF";
  put(out, std::uint32_t{2});
  put(out, std::uint32_t{0});
  put(out, static_cast<std::uint32_t>(json.size()));
  out += "JSON" + json;
  put(out, static_cast<std::uint32_t>(data().size() + 3));  // as if it were padded
  out += std::string("BIN\0", 4) + data();
  const Result<PointCloud> cloud = read(out);
  ASSERT_TRUE(cloud) << cloud.error().message;
  EXPECT_EQ(cloud->world(1), glm::dvec3(18, 10, 12));
}

TEST(Gltf, extensions_that_matter_are_refused_where_they_are_needed_and_told_where_not) {
  const auto with = [](const std::string& extensions) {
    return changed(R"("textures":[{}])", extensions);
  };
  EXPECT_THAT(error_of(with(R"("extensionsRequired":["EXT_mesh_gpu_instancing"])")),
              HasSubstr("needs the extension EXT_mesh_gpu_instancing"));
  EXPECT_THAT(error_of(with(R"("extensionsRequired":[7])")), HasSubstr("not text"));
  std::vector<std::string> unread;
  const std::string harmless =
      R"("extensionsRequired":["KHR_mesh_quantization","KHR_materials_unlit"],)"
      R"("extensionsUsed":["KHR_materials_unlit","EXT_mesh_gpu_instancing"])";
  ASSERT_TRUE(read(with(harmless), &unread));
  EXPECT_THAT(unread, ElementsAre("EXT_mesh_gpu_instancing"));
}

TEST(Gltf, what_vertices_have_besides_is_told) {
  std::vector<std::string> unread;
  ASSERT_TRUE(read(changed(R"("COLOR_0":2}})",
                           R"("COLOR_0":2,"COLOR_1":2,"TEXCOORD_0":1,"_HEAT":2},"targets":[]})"),
                   &unread));
  EXPECT_THAT(unread, ElementsAre("textures", "COLOR_1", "_HEAT", "morph targets"));
}

TEST(Gltf, each_lie_is_an_error_that_names_the_part) {
  EXPECT_THAT(error_of(changed(R"("count":2)", R"("count":3)")), HasSubstr("accessors/0: its 3"));
  EXPECT_THAT(error_of(changed(R"("count":2)", R"("count":9007199254740991)")),
              HasSubstr("do not fit"));
  EXPECT_THAT(error_of(changed(R"({"bufferView":0,)", R"({"bufferView":9,)")),
              HasSubstr("no bufferViews/9"));
  EXPECT_THAT(error_of(changed(R"({"bufferView":0,)", R"({)")), HasSubstr("no buffer view"));
  EXPECT_THAT(error_of(changed(R"("buffer":0,"byteLength":24)", R"("buffer":0,"byteLength":65)")),
              HasSubstr("bufferViews/0: ends at byte 65 of buffers/0, which has 64"));
  EXPECT_THAT(error_of(changed(R"("buffer":0,"byteLength":24)", R"("buffer":3,"byteLength":24)")),
              HasSubstr("no buffers/3"));
  EXPECT_THAT(error_of(changed("5126", "5124")), HasSubstr("no component type 5124"));
  EXPECT_THAT(error_of(changed("VEC3", "MAT3")), HasSubstr("not a vector"));
  EXPECT_THAT(error_of(changed(R"("NORMAL":1)", R"("NORMAL":7)")), HasSubstr("no accessors/7"));
  EXPECT_THAT(error_of(changed(R"("mesh":0)", R"("mesh":4)")), HasSubstr("no meshes/4"));
  EXPECT_THAT(error_of(changed(R"("children":[1])", R"("children":[0])")), HasSubstr("nodes/0"));
  EXPECT_THAT(error_of(changed(R"("children":[1])", R"("children":[1,1])")), HasSubstr("nodes/1"));
  EXPECT_THAT(error_of(changed(R"("children":[1])", R"("children":[2])")), HasSubstr("no node 2"));
  EXPECT_THAT(error_of(changed(R"([10,0,0])", R"([10,0])")), HasSubstr("translation"));
  EXPECT_THAT(error_of(changed(R"({"byteLength":64})", R"({"byteLength":64,"uri":"../a.bin"})")),
              HasSubstr("is in another file"));
  EXPECT_THAT(error_of(changed(R"("textures":[{}])",
                               R"("extensionsRequired":["KHR_draco_mesh_compression"])")),
              HasSubstr("KHR_draco_mesh_compression"));
  EXPECT_THAT(error_of("glTF\x01"), HasSubstr("JSON"));
  EXPECT_THAT(error_of("[]"), HasSubstr("not an object"));
  DecodeLimits few;
  few.max_memory = 64;
  EXPECT_THAT(read(glb(kJson), nullptr, few).error().message, HasSubstr("more than 1 vertices"));
}

TEST(Gltf, any_part_of_a_file_is_refused_in_one_line) {
  const std::string whole = glb(kJson);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const Result<PointCloud> cloud = read(whole.substr(0, size));
    ASSERT_FALSE(cloud) << size;
    EXPECT_EQ(cloud.error().message.find('\n'), std::string::npos);
  }
}

}  // namespace
}  // namespace pointreel::gltf_test
