#include "codec/files/gltf_buffers.h"

#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codec/files/cloud_file.h"
#include "tests/temporary_folder.h"

namespace pointreel::gltf_buffers_test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

/// Three points, of which each buffer has all or some.
std::string gltf(const std::string& buffers) {
  return R"({"asset":{"version":"2.0"},"meshes":[{"primitives":[{"mode":0,"attributes":)"
         R"({"POSITION":0}}]}],"accessors":[{"bufferView":0,"componentType":5126,"count":2,)"
         R"("type":"VEC3"}],"bufferViews":[{"buffer":0,"byteLength":24}],"buffers":[)" +
         buffers + "]}";
}

std::string two_points() {
  const float values[]{1, 2, 3, 4, 5, 6};
  return {reinterpret_cast<const char*>(values), sizeof(values)};
}

class GltfBuffers : public testing::Test {
 protected:
  GltfBuffers() {
    fs::create_directories(folder_ / "scan/below");
    folder_.write("secret.bin", two_points());
    folder_.write("scan/a b.bin", two_points() + "more than the buffer has");
    folder_.write("scan/below/c.bin", two_points());
  }

  /// What reading a file with this buffer gives.
  Result<LoadedCloud> read(const std::string& uri) const {
    const std::string buffer = R"({"byteLength":24,"uri":")" + uri + R"("})";
    return read_cloud_file(folder_.write("scan/a.gltf", gltf(buffer)));
  }
  std::string error_of(const std::string& uri) const {
    const auto loaded = read(uri);
    return loaded ? "it was read" : loaded.error().message;
  }

  TemporaryFolder folder_;
};

TEST_F(GltfBuffers, in_the_folder_of_the_file_and_below_are_read) {
  for (const char* uri : {"a%20b.bin", "a b.bin", "./below/c.bin", "below/%63.bin"}) {
    const auto loaded = read(uri);
    ASSERT_TRUE(loaded) << loaded.error().message;
    ASSERT_EQ(loaded->cloud.size(), 2u);
    EXPECT_EQ(loaded->cloud.world(1), glm::dvec3(4, 5, 6));
  }
}

TEST_F(GltfBuffers, are_there_too_where_a_file_is_fetched_to_be_read_elsewhere) {
  ASSERT_TRUE(read("a b.bin"));
  const auto fetched = fetch_cloud_frame({folder_ / "scan/a.gltf"}, 4096);
  ASSERT_TRUE(fetched) << fetched.error().message;
  const auto loaded = read_cloud(fetched->bytes, fetched->format);
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_EQ(loaded->cloud.size(), 2u);
}

TEST_F(GltfBuffers, elsewhere_are_refused) {
  fs::create_symlink(folder_ / "secret.bin", folder_ / "scan/link.bin");
  fs::create_directory_symlink(folder_.path(), folder_ / "scan/up");
  for (const std::string& uri :
       {std::string("../secret.bin"), std::string("below/../../secret.bin"),
        std::string("%2e%2e/secret.bin"), std::string("..%2fsecret.bin"),
        (folder_ / "secret.bin").string(),
        std::string("file://") + (folder_ / "secret.bin").string(),
        std::string("https://example.org/a.bin"), std::string("link.bin"),
        std::string("up/secret.bin"), std::string("below"), std::string("."), std::string("")}) {
    EXPECT_THAT(error_of(uri),
                AllOf(StartsWith((folder_ / "scan/a.gltf").string() + ": buffers/0: uri "),
                      HasSubstr("is not a file in the folder of this one")))
        << uri;
  }
  EXPECT_THAT(error_of("missing.bin"), HasSubstr("buffers/0: uri missing.bin: No such file"));
}

TEST_F(GltfBuffers, that_are_too_short_are_an_error_of_the_view) {
  folder_.write("scan/short.bin", "12345678");
  EXPECT_THAT(error_of("short.bin"), HasSubstr("ends at byte 24 of buffers/0, which has 8"));
}

TEST_F(GltfBuffers, take_no_more_memory_than_allowed_together) {
  const std::string buffer = R"({"byteLength":24,"uri":"a b.bin"})";
  const std::string text = gltf(buffer + "," + buffer + "," + buffer);
  const ByteView view(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  EXPECT_TRUE(embed_gltf_buffers(view, folder_ / "scan", 72));
  const auto refused = embed_gltf_buffers(view, folder_ / "scan", 71);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::limit);
  EXPECT_THAT(refused.error().message, StartsWith("buffers/2: takes 24 bytes"));
}

}  // namespace
}  // namespace pointreel::gltf_buffers_test
