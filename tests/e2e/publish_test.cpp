// What `publish` says about how much of a stream has arrived at the server.

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "codec/files/cloud_file.h"
#include "codec/files/cloud_folder.h"
#include "codec/files/ply.h"
#include "codec/package/manifest.h"
#include "pointreel/package.h"
#include "tests/e2e/process.h"
#include "tests/e2e/server_address.h"
#include "tests/paths.h"
#include "tests/temporary_folder.h"
#include "tests/wait.h"

namespace pointreel::e2e::publish_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

class PublishTest : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(folder_ / "frames");
    for (int i = 0; i < 10; ++i) {
      PointCloud cloud;
      for (int j = 0; j < 500; ++j)
        cloud.positions.emplace_back(0.01f * static_cast<float>(j), i, 0);
      ASSERT_TRUE(write_ply(folder_ / "frames" / fmt::format("{}.ply", i), cloud));
    }
  }

  fs::path record() const { return folder_ / "record"; }
  std::vector<std::string> publish(const std::string& address,
                                   const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {
        "publish", "-i",   (folder_ / "frames").string(),    "--fps",
        "20",      "--to", "ws://" + address + "/live/stage"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }

  const TemporaryFolder folder_;
};

TEST_F(PublishTest, counts_what_the_server_has_accepted) {
  Background server("pointreel-server",
                    {"serve", "--live", "--record", record().string(), "--listen", "127.0.0.1:0"});
  const std::string address = server_address(server);
  ASSERT_FALSE(address.empty());
  const Outcome published = run("pointreel-server", publish(address, {"--json"}));
  EXPECT_EQ(published.exit_code, 0) << published.err;
  EXPECT_EQ(server.end(SIGTERM), 0);
  const auto report = nlohmann::json::parse(published.out, nullptr, false);
  ASSERT_FALSE(report.is_discarded()) << published.out;
  const auto& sent = report["sent"];
  const auto manifest = read_manifest(record() / "stage");
  ASSERT_TRUE(manifest) << manifest.error().message;
  EXPECT_EQ(sent["accepted_frames"].get<std::uint32_t>(), manifest->frame_count());
  EXPECT_EQ(sent["accepted_layers"], sent["layers"]);
  EXPECT_EQ(report["frames"].get<int>(),
            sent["accepted_frames"].get<int>() + sent["dropped_frames"].get<int>());
}

TEST_F(PublishTest, frames_that_are_encoded_side_by_side_keep_their_order) {
  // Every third frame takes much longer than those after it, and one cannot be read. The height of
  // a frame's points tells which it is.
  for (int i = 0; i < 30; ++i) {
    PointCloud cloud;
    for (int j = 0; j < (i % 3 == 0 ? 30'000 : 100); ++j)
      cloud.positions.emplace_back(j % 173, 10 * i, j / 173);
    ASSERT_TRUE(write_ply(folder_ / "frames" / fmt::format("{}.ply", i), cloud));
  }
  std::ofstream(folder_ / "frames" / "11.ply") << "ply\n";
  Background server("pointreel-server",
                    {"serve", "--live", "--record", record().string(), "--listen", "127.0.0.1:0"});
  const std::string address = server_address(server);
  ASSERT_FALSE(address.empty());
  const Outcome published = run("pointreel-server", publish(address, {"--threads", "4", "--json"}));
  EXPECT_EQ(published.exit_code, 0) << published.err;
  EXPECT_THAT(published.err, HasSubstr("11.ply"));
  EXPECT_EQ(nlohmann::json::parse(published.out)["unusable"], 1);
  EXPECT_EQ(server.end(SIGTERM), 0);
  const fs::path back = folder_ / "back";
  const Outcome unpacked =
      run("pointreel-server", {"unpack", "-i", (record() / "stage").string(), "-o", back.string()});
  ASSERT_EQ(unpacked.exit_code, 0) << unpacked.err;
  std::vector<long> frames;
  const std::vector<fs::path> files = list_cloud_files({back}).value();
  for (const fs::path& file : files) {
    const PointCloud cloud = read_cloud_file(file)->cloud;
    const double height = cloud.origin.y + cloud.positions.at(0).y;
    frames.push_back(std::lround(height / 10.0));
  }
  ASSERT_GT(frames.size(), 5u);
  EXPECT_TRUE(std::is_sorted(frames.begin(), frames.end())) << testing::PrintToString(frames);
  EXPECT_EQ(std::adjacent_find(frames.begin(), frames.end()), frames.end());
}

TEST_F(PublishTest, a_killed_publisher_takes_its_name_back_and_a_living_one_keeps_it) {
  Background server("pointreel-server", {"serve", "--live", "--record", record().string(),
                                         "--listen", "127.0.0.1:0", "--publisher-grace", "3600"});
  const std::string address = server_address(server);
  ASSERT_FALSE(address.empty());
  const fs::path state = folder_ / "state", err = folder_ / "err";
  const Surroundings same_user{{"XDG_STATE_HOME=" + state.string()}, err.string(), {}};
  Background first("pointreel-server", publish(address, {"--loop"}), same_user);
  ASSERT_TRUE(wait_until([&] { return fs::exists(record() / "stage"); }));
  Background second("pointreel-server", publish(address), same_user);
  EXPECT_EQ(second.end(0), 1);
  EXPECT_TRUE(first.running());
  first.end(SIGKILL);
  Background again("pointreel-server", publish(address), same_user);
  EXPECT_EQ(again.end(0), 0);
  EXPECT_TRUE(fs::is_empty(state / "pointreel" / "publishers"));
}

TEST_F(PublishTest, fails_if_nothing_answers) {
  const Outcome published = run("pointreel-server", publish("127.0.0.1:1"));
  EXPECT_EQ(published.exit_code, 1);
  EXPECT_THAT(published.err, HasSubstr("nothing arrived"));
}

TEST_F(PublishTest, fails_if_no_frame_can_be_used) {
  Background server("pointreel-server", {"serve", "--live", "--listen", "127.0.0.1:0"});
  const std::string address = server_address(server);
  for (const auto& file : fs::directory_iterator(folder_ / "frames")) fs::resize_file(file, 100);
  const Outcome published = run("pointreel-server", publish(address));
  EXPECT_EQ(published.exit_code, 1);
  EXPECT_THAT(published.err, HasSubstr("no frame that could be encoded"));
}

TEST_F(PublishTest, tells_what_arrived_before_its_pipe_broke_off) {
  Background server("pointreel-server", {"serve", "--live", "--listen", "127.0.0.1:0"});
  const std::string address = server_address(server);
  ASSERT_FALSE(address.empty());
  // A whole frame behind its size, time for it to be read, and then half a frame.
  const std::string frame = (folder_ / "frames" / "0.ply").string();
  const std::uint32_t size = static_cast<std::uint32_t>(fs::file_size(frame));
  std::ofstream(folder_ / "size", std::ios::binary)
      .write(reinterpret_cast<const char*>(&size), sizeof(size));
  const Outcome outcome =
      run("/bin/sh", {"-c",
                      "(cat \"$1\" \"$2\"; sleep 1; cat \"$1\"; head -c 100 \"$2\") | "
                      "\"$3\" publish -i - --json --to \"$4\"",
                      "sh", (folder_ / "size").string(), frame,
                      program_folder() / "pointreel-server", "ws://" + address + "/live/stage"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("ends within frame 1"));
  const auto report = nlohmann::json::parse(outcome.out, nullptr, false);
  ASSERT_FALSE(report.is_discarded()) << outcome.out;
  EXPECT_EQ(report["sent"]["accepted_frames"], 1);
}

TEST_F(PublishTest, says_once_that_a_name_is_taken_and_fails) {
  Background server("pointreel-server",
                    {"serve", "--live", "--record", record().string(), "--listen", "127.0.0.1:0"});
  const std::string address = server_address(server);
  ASSERT_FALSE(address.empty());
  Background first("pointreel-server", publish(address, {"--loop"}));
  ASSERT_TRUE(wait_until([&] { return fs::exists(record() / "stage" / kManifestName); }));
  const Outcome second = run("pointreel-server", publish(address));
  EXPECT_EQ(second.exit_code, 1);
  EXPECT_LE(std::count(second.err.begin(), second.err.end(), '\n'), 2) << second.err;
  EXPECT_THAT(second.err, HasSubstr("stage"));
  EXPECT_THAT(second.err, Not(HasSubstr("connected again")));
  EXPECT_EQ(first.end(SIGINT), 0) << "the first publisher is not disturbed";
}

TEST_F(PublishTest, cleans_frames_before_it_encodes_them) {
  // A rough sheet, and a point far above it.
  PointCloud sheet;
  for (int i = 0; i < 2500; ++i) {
    sheet.positions.emplace_back(i % 50, 0.4f * static_cast<float>(i * 7919 % 11 - 5) / 5.0f,
                                 i / 50);
    sheet.normals.emplace_back(0.0f, 1.0f, 0.0f);
  }
  sheet.positions.emplace_back(25.0f, 40.0f, 25.0f);
  sheet.normals.emplace_back(0.0f, 1.0f, 0.0f);
  for (int i = 0; i < 10; ++i) {
    ASSERT_TRUE(write_ply(folder_ / "frames" / fmt::format("{}.ply", i), sheet));
  }
  Background server("pointreel-server",
                    {"serve", "--live", "--record", record().string(), "--listen", "127.0.0.1:0"});
  const std::string address = server_address(server);
  ASSERT_FALSE(address.empty());
  const Outcome published = run("pointreel-server", publish(address, {"--clean", "auto"}));
  EXPECT_EQ(published.exit_code, 0) << published.err;
  EXPECT_EQ(server.end(SIGTERM), 0);
  const auto manifest = read_manifest(record() / "stage");
  ASSERT_TRUE(manifest);
  EXPECT_LT(manifest->bounds.max.y, 1.0) << "the point far above is gone";
}

TEST_F(PublishTest, says_once_that_frames_are_not_cleaned) {
  Background server("pointreel-server", {"serve", "--live", "--listen", "127.0.0.1:0"});
  const std::string address = server_address(server);
  ASSERT_FALSE(address.empty());
  const Outcome published = run("pointreel-server", publish(address, {"--clean", "1000"}));
  EXPECT_EQ(published.exit_code, 0) << published.err;
  const auto told = published.err.find("0.ply: not cleaned: around most points");
  EXPECT_NE(told, std::string::npos) << published.err;
  EXPECT_EQ(published.err.find("not cleaned", told + 20), std::string::npos) << published.err;
}

}  // namespace
}  // namespace pointreel::e2e::publish_test
