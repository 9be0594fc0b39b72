#include <filesystem>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "client/source/open_source.h"
#include "codec/package/manifest.h"
#include "pointreel/chunks.h"
#include "tests/packed_reel.h"
#include "tests/scripted_http_server.h"
#include "tests/small_package.h"
#include "tests/temporary_folder.h"

namespace pointreel::source_test {
namespace {

using testing::EndsWith;
using testing::HasSubstr;
namespace fs = std::filesystem;

TEST(FetchedLayer, splits_into_its_chunks) {
  const FetchedLayer layer{offsets(0, 9), {4, 3, 2}};
  const Chunks<ByteView> view = layer.view();
  EXPECT_EQ(Bytes(view.geometry.begin(), view.geometry.end()), offsets(0, 4));
  EXPECT_EQ(Bytes(view.colors.begin(), view.colors.end()), offsets(4, 3));
  EXPECT_EQ(Bytes(view.normals.begin(), view.normals.end()), offsets(7, 2));
}

TEST(Ranges, cover_a_prefix_of_the_stored_order) {
  const Manifest manifest = small_manifest();
  const auto all = ranges_of(manifest, 1, {});
  ASSERT_EQ(all->size(), 2u);
  EXPECT_EQ((*all)[0].offset, 9u);
  EXPECT_EQ((*all)[0].sizes, (Chunks<std::uint32_t>{10, 6, 5}));
  EXPECT_EQ((*all)[1].offset, 5u);
  EXPECT_EQ((*ranges_of(manifest, 1, {0, kAllLayers, true, false}))[0].sizes,
            (Chunks<std::uint32_t>{10, 6, 0}));
  EXPECT_EQ((*ranges_of(manifest, 1, {0, kAllLayers, false, false}))[0].sizes,
            (Chunks<std::uint32_t>{10, 0, 0}));
  EXPECT_EQ((*ranges_of(manifest, 1, {0, kAllLayers, false, true}))[0].sizes,
            (Chunks<std::uint32_t>{10, 6, 5}))
      << "the normals follow the colours";
  EXPECT_EQ(ranges_of(manifest, 1, {0, 1, true, true})->size(), 1u);
}

TEST(Ranges, refuse_a_frame_that_the_reel_does_not_have) {
  Manifest manifest = small_manifest();
  manifest.segments[0].layers[0].frames[0].geometry = 0x7fffffff;
  EXPECT_FALSE(ranges_of(manifest, 0, {}));
}

TEST(OpenSource, reports_every_problem_in_one_line) {
  EXPECT_THAT(open_source("/no/such/folder").error().message, HasSubstr("no such file or folder"));
  EXPECT_THAT(open_source("ftp://host/x").error().message, HasSubstr("ftp:// is not supported"));
  EXPECT_THAT(open_source("http://").error().message, HasSubstr("names no host"));
}

TEST(OpenSource, reports_a_folder_that_is_neither_a_package_nor_holds_clouds) {
  const TemporaryFolder folder;
  folder.write("readme.md", "hello");
  EXPECT_EQ(open_source(folder.path().string()).error().message,
            folder.path().string() +
                ": is not a package (it has no reel.json), and has no point cloud files");
}

TEST(OpenSource, reports_a_file_that_is_not_a_cloud) {
  const TemporaryFolder folder;
  const std::string photo = folder.write("photo.jpg", "\xff\xd8").string();
  EXPECT_THAT(
      open_source(photo).error().message,
      testing::AllOf(HasSubstr(photo), HasSubstr("not a known point cloud file"),
                     EndsWith("; known are PLY, Draco, nuScenes, PCD, LAS, text, OBJ, glTF, "
                              "numpy, KITTI, MCAP and depth video")));
  const std::string cut = folder.write("cut.ply", "ply\nformat ascii 1.0\n").string();
  EXPECT_THAT(open_source(cut).error().message, HasSubstr(cut + ": "));
}

TEST(OpenSource, reports_a_dangling_symbolic_link) {
  const TemporaryFolder folder;
  fs::create_symlink("/no/such/file", folder / "gone.ply");
  EXPECT_THAT(open_source((folder / "gone.ply").string()).error().message,
              HasSubstr("gone.ply: links to a file or folder that is not there"));
}

TEST(OpenSource, reports_an_invalid_manifest) {
  const TemporaryFolder folder;
  const std::string path = folder.write("reel.json", "<html>").string();
  for (const std::string& where : {path, folder.path().string()})
    EXPECT_EQ(open_source(where).error().message,
              path + ": is not valid JSON; give the folder or address of a package");
}

TEST(OpenSource, says_which_options_for_files_are_of_no_use_for_a_package) {
  const TemporaryFolder folder;
  folder.write("reel.json", write_manifest(small_manifest()));
  std::vector<std::string> said;
  SourceOptions options;
  options.say = [&](const std::string& line) { said.push_back(line); };
  (void)open_source(folder.path().string(), options);
  EXPECT_THAT(said, testing::IsEmpty());
  options.fps = 5.0;
  options.placement.scale = 2.0;
  (void)open_source(folder.path().string(), options);
  EXPECT_THAT(said, testing::ElementsAre("warning: " + folder.path().string() +
                                         ": is a package, which is shown as it is: --fps, --scale "
                                         "are not used"));
}

TEST(OpenSource, names_the_newer_version_of_a_package) {
  const TemporaryFolder folder;
  std::string text = write_manifest(small_manifest());
  const std::size_t version = text.find("\"version\": 1");
  ASSERT_NE(version, std::string::npos);
  text.replace(version, 12, "\"version\": 7");
  folder.write("reel.json", text);
  const std::string said = "format version 7 is newer than 1, the newest that this program reads";
  const std::string local = open_source(folder.path().string()).error().message;
  EXPECT_THAT(local, testing::AllOf(HasSubstr("reel.json: " + said), HasSubstr("update it")));
  EXPECT_THAT(local, testing::Not(HasSubstr("give the folder")));
  ScriptedHttpServer server([&](int socket, const std::string&) {
    answer(socket, "200 OK", "", text);
    return true;
  });
  EXPECT_THAT(open_source(server.url() + "/reel", patient()).error().message,
              HasSubstr("/reel/reel.json: " + said));
}

TEST(OpenSource, reports_a_host_that_does_not_answer) {
  std::string url;
  {
    const ScriptedHttpServer server([](int, const std::string&) { return false; });
    url = server.url();
  }
  EXPECT_THAT(open_source(url + "/reel", patient()).error().message,
              testing::AllOf(HasSubstr(url), HasSubstr("nothing answers there")));
}

TEST(OpenSource, can_be_stopped) {
  std::stop_source stop;
  ScriptedHttpServer server([&](int, const std::string&) {
    stop.request_stop();
    return true;
  });
  SourceOptions options = patient();
  options.stop = stop.get_token();
  EXPECT_FALSE(open_source(server.url() + "/reel", options));
}

TEST(FileSource, reads_the_requested_ranges) {
  const TemporaryFolder folder;
  folder.write("reel.json", write_manifest(small_manifest()));
  folder.write("0.base.bin", text_of(offsets(0, 30)));
  folder.write("0.full.bin", text_of(offsets(0, 8)));
  for (const fs::path& where : {folder.path(), folder.path() / "reel.json"}) {
    auto source = open_source(where.string());
    ASSERT_TRUE(source) << source.error().message;
    EXPECT_EQ((*source)->manifest().name, "small");
    const auto frame = (*source)->fetch({1});
    ASSERT_TRUE(frame);
    ASSERT_EQ(frame->layers.size(), 2u);
    EXPECT_EQ(frame->layers[0].bytes, offsets(9, 21));
    EXPECT_EQ(frame->layers[1].bytes, offsets(5, 3));
    EXPECT_EQ((*source)->fetch({0, {0, kAllLayers, false, false}})->layers[0].bytes, offsets(0, 4));
  }
}

TEST(FileSource, names_a_file_that_is_missing_or_too_short) {
  const TemporaryFolder folder;
  folder.write("reel.json", write_manifest(small_manifest()));
  folder.write("0.base.bin", text_of(offsets(0, 29)));
  auto source = open_source(folder.path().string());
  ASSERT_TRUE(source);
  EXPECT_THAT((*source)->fetch({1}).error().message,
              testing::AllOf(HasSubstr("0.base.bin"), HasSubstr("29"), HasSubstr("30")));
  EXPECT_THAT((*source)->fetch({0}).error().message, HasSubstr("0.full.bin"));
}

TEST(FolderSource, takes_its_files_in_natural_order_and_its_times_from_the_rate) {
  const TemporaryFolder folder;
  for (const int i : {1, 2, 10})
    folder.write(fmt::format("f{}.ply", i),
                 fmt::format("ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty "
                             "float y\nproperty float z\nend_header\n0 0 0\n{} 2 3\n",
                             i));
  SourceOptions options;
  options.fps = 25.0;
  auto source = open_source(folder.path().string(), options);
  ASSERT_TRUE(source) << source.error().message;
  const Manifest& manifest = (*source)->manifest();
  EXPECT_EQ(manifest.frame_count(), 3u);
  EXPECT_EQ(manifest.up, 'y');
  EXPECT_EQ(manifest.duration_us, 120'000u);
  EXPECT_EQ(frame_time_us(manifest, 2), 80'000u);
  EXPECT_EQ(manifest.bounds.max, glm::dvec3(10.0, 2.0, 3.0)) << "of all three";
  EXPECT_FALSE(manifest.colors);
  EXPECT_THAT(text_of((*source)->fetch({1})->file.view()), HasSubstr("\n2 2 3\n"));
  EXPECT_THAT(text_of((*source)->fetch({2})->file.view()), HasSubstr("\n10 2 3\n"));
}

TEST(FolderSource, refuses_a_folder_without_frames) {
  const TemporaryFolder folder;
  EXPECT_FALSE(open_source(folder.path().string()));
}

using PackedSource = PackTest;

TEST_F(PackedSource, does_not_wait_for_a_layer_that_is_a_pipe) {
  write_frames(1);
  ASSERT_TRUE(pack(options()));
  const auto source = open_source(reel_.string());
  ASSERT_TRUE(source) << source.error().message;
  const fs::path layer = reel_ / (*source)->manifest().segments[0].layers[0].path;
  fs::remove(layer);
  ASSERT_EQ(::mkfifo(layer.c_str(), 0600), 0);
  const auto fetched = (*source)->fetch(FetchRequest{0});
  ASSERT_FALSE(fetched);
  EXPECT_THAT(fetched.error().message, HasSubstr("is not a regular file"));
}

}  // namespace
}  // namespace pointreel::source_test
