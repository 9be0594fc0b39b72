// Packages with context tables of their own, from pack to player.

#include <filesystem>
#include <random>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/prepare/prepare.h"
#include "client/source/open_source.h"
#include "codec/package/manifest.h"
#include "server/inspect/inspect.h"
#include "server/pack/packer.h"
#include "server/serve/http_server.h"
#include "server/service/catalog.h"
#include "tests/packed_clouds.h"

namespace pointreel::trained_package_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// Points in pairs at a fixed offset, which no surface has, so that there is something to learn.
PointCloud pairs(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  PointCloud cloud;
  for (std::size_t i = 0; i < count; ++i) {
    const glm::vec3 at(random() % 64, random() % 64, random() % 8 * 8);
    cloud.positions.push_back(at);
    cloud.positions.push_back(at + 2.0f);
  }
  return cloud;
}

class TrainedPackage : public testing::Test {
 protected:
  void write_pairs(unsigned frames, std::size_t points = 1500) {
    fs::create_directories(folder_.path() / "in");
    for (unsigned i = 0; i < frames; ++i) {
      ASSERT_TRUE(write_ply(folder_.path() / "in" / fmt::format("{}.ply", i), pairs(points, i)));
    }
  }

  PackOptions options(const std::string& name) const {
    PackOptions options = pack_options(folder_.path() / "in", folder_.path() / name);
    options.encode.codec = OctreeOptions{Entropy::context, DepthRule::by_delta(0.05)};
    options.voxel = 1.0;
    options.train = true;
    return options;
  }

  PackSummary packed(const PackOptions& options) const {
    const Result<PackSummary> summary = pack(options);
    if (!summary) ADD_FAILURE() << summary.error().message;
    return summary.value_or(PackSummary{});
  }

  fs::path reel() const { return folder_.path() / "reel"; }

  TemporaryFolder folder_;
};

TEST_F(TrainedPackage, is_smaller_and_decodes_to_the_same_frames) {
  write_pairs(10);
  const PackSummary trained = packed(options("reel"));
  PackOptions built_in = options("built_in");
  built_in.train = false;
  const PackSummary plain = packed(built_in);
  ASSERT_TRUE(trained.learnt);
  EXPECT_FALSE(plain.learnt);
  EXPECT_EQ(trained.learnt->samples, 10u);
  EXPECT_LT(trained.bytes, plain.bytes * 19 / 20);
  EXPECT_NEAR(static_cast<double>(plain.bytes - trained.bytes), trained.learnt->saved_bytes,
              0.02 * static_cast<double>(plain.bytes));
  const auto report = verify(reel());
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_TRUE(report->faults.empty());
  EXPECT_EQ(report->bytes + fs::file_size(reel() / "reel.json"), trained.bytes);

  UnpackOptions unpacking;
  for (const char* name : {"reel", "built_in"}) {
    unpacking.input = folder_.path() / name;
    unpacking.output = folder_.path() / (std::string(name) + "_out");
    ASSERT_TRUE(unpack(unpacking));
  }
  EXPECT_EQ(contents(folder_.path() / "reel_out"), contents(folder_.path() / "built_in_out"));
}

TEST_F(TrainedPackage, is_the_same_on_any_number_of_threads) {
  write_pairs(9, 800);
  PackOptions how = options("reel");
  how.segment_frames = 2;  // five segments, of which four are sampled
  how.threads = 1;
  const PackSummary summary = packed(how);
  EXPECT_GT(summary.learnt->bytes, 0u);
  EXPECT_LT(summary.learnt->samples, 9u);
  const auto alone = contents(reel());
  how.threads = 4;
  how.force = true;
  packed(how);
  EXPECT_EQ(contents(reel()), alone);
}

TEST_F(TrainedPackage, keeps_the_built_in_tables_if_its_own_would_not_pay_off) {
  write_pairs(2, 20);
  for (const bool cube_per_frame : {false, true}) {
    PackOptions how = options("reel");
    how.force = true;
    how.cube_per_frame = cube_per_frame;
    const PackSummary summary = packed(how);
    ASSERT_TRUE(summary.learnt);
    EXPECT_EQ(summary.learnt->bytes, 0u);
    EXPECT_FALSE(read_manifest(reel())->tables);
  }
}

TEST_F(TrainedPackage, is_played_and_served_with_its_tables) {
  write_pairs(8);
  packed(options("reel"));
  auto catalog = Catalog::load({reel()});
  ASSERT_TRUE(catalog) << catalog.error().message;
  HttpServerOptions how;
  how.listen = parse_listen_address("127.0.0.1:0").value();
  const auto server = HttpServer::start(std::move(*catalog), how);
  ASSERT_TRUE(server) << server.error().message;
  for (const std::string& where :
       {reel().string(), fmt::format("http://127.0.0.1:{}/reel", (*server)->port())}) {
    auto source = open_source(where);
    ASSERT_TRUE(source) << source.error().message;
    auto fetched = (*source)->fetch({3});
    ASSERT_TRUE(fetched) << fetched.error().message;
    const auto frame = prepare_frame(*fetched, {3}, {});
    ASSERT_TRUE(frame) << frame.error().message;
    fetched->tables = nullptr;
    const auto without = prepare_frame(*fetched, {3}, {});
    ASSERT_FALSE(without);
    EXPECT_THAT(without.error().message, HasSubstr("tables"));
  }
}

TEST_F(TrainedPackage, is_refused_if_its_tables_are_lost_or_changed) {
  write_pairs(8);
  packed(options("reel"));
  const fs::path tables = reel() / read_manifest(reel())->tables->path;
  const std::string good = read_text(tables);
  std::string flipped = good;
  flipped[good.size() / 2] ^= 1;
  const auto refused = [&] {
    const auto report = verify(reel());
    ASSERT_TRUE(report) << report.error().message;
    ASSERT_FALSE(report->faults.empty());
    EXPECT_EQ(report->faults.front().file, tables.filename().string());
    EXPECT_GT(report->faults.size(), 8u) << "every frame fails to decode too";
    EXPECT_FALSE(open_source(reel().string()));
    UnpackOptions unpacking;
    unpacking.input = reel();
    unpacking.output = folder_.path() / "out";
    EXPECT_FALSE(unpack(unpacking));
  };
  for (const std::string& bad : {flipped, good.substr(0, good.size() - 1), std::string()}) {
    write_file(tables, bad);
    refused();
  }
  fs::remove(tables);
  refused();
}

}  // namespace
}  // namespace pointreel::trained_package_test
