#include "datasets_synthetic/write_sequence.h"

#include <filesystem>
#include <map>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include "codec/files/ply.h"
#include "datasets_synthetic/hard_cases.h"
#include "datasets_synthetic/write_folder.h"
#include "datasets_synthetic/write_hard.h"
#include "tests/packed_reel.h"

namespace pointreel::write_sequence_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

SequenceJob small_job(const fs::path& output, Sampler sampler) {
  SequenceJob job;
  job.output = output.string();
  job.frames = 2;
  job.options.sampler = sampler;
  job.options.points = 500;
  job.options.ldc.spacing = 0.05;
  return job;
}

const Motion& walking() { return *find_motion("walk"); }

TEST(WriteSequence, writes_a_file_for_each_frame_and_counts_the_points) {
  const TemporaryFolder folder;
  const SequenceJob job = small_job(folder.path() / "out", Sampler::ldc);
  const auto summary = write_sequence(walking(), job);
  ASSERT_TRUE(summary) << summary.error().message;
  const auto files = contents(folder.path() / "out");
  ASSERT_EQ(files.size(), 2u);
  std::size_t sum = 0, least = ~std::size_t{0}, most = 0;
  for (int i = 0; i < 2; ++i) {
    const std::string& text = files.at("frame_000" + std::to_string(i) + ".ply");
    const PointCloud cloud =
        read_ply({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}).value();
    EXPECT_EQ(cloud.positions, sequence_frame(walking(), job.options, i)->positions);
    EXPECT_TRUE(cloud.has_normals() && cloud.has_colors());
    sum += cloud.size();
    least = std::min(least, cloud.size());
    most = std::max(most, cloud.size());
  }
  EXPECT_NEAR(summary->mean_points, static_cast<double>(sum) / 2.0, 1e-6);
  EXPECT_EQ(summary->min_points, least);
  EXPECT_EQ(summary->max_points, most);
}

TEST(WriteSequence, writes_the_same_bytes_on_one_thread_and_on_two) {
  std::vector<std::map<std::string, std::string>> results;
  for (const int threads : {1, 2}) {
    const TemporaryFolder folder;
    SequenceJob job = small_job(folder.path() / "out", Sampler::ldc);
    job.options.voxels = voxel_grid(sequence_bounds(walking(), 30.0, job.frames), 5);
    tbb::task_arena arena(threads);
    ASSERT_TRUE(arena.execute([&] { return write_sequence(walking(), job); }));
    results.push_back(contents(folder.path() / "out"));
  }
  EXPECT_EQ(results[0], results[1]);
}

TEST(WriteSequence, chooses_a_grid_that_contains_every_frame) {
  const VoxelGrid grid = voxel_grid(sequence_bounds(walking(), 30.0, 60), 6);
  for (const int number : {13, 44}) {
    SequenceOptions options;
    options.voxels = grid;
    const PointCloud voxels = sequence_frame(walking(), options, number).value();
    const Box box = bounds(voxels);
    EXPECT_GE(std::min({box.min.x, box.min.y, box.min.z}), 0.0);
    EXPECT_LE(std::max({box.max.x, box.max.y, box.max.z}), 63.0);
    EXPECT_GE(box.extent().y, 60.0) << "the figure fills the height of its cube";
    // The voxels lie at the same place as the points of a sample, which does not depend on the
    // grid.
    options.voxels.reset();
    options.sampler = Sampler::uniform;
    options.points = 2000;
    const Box sampled = bounds(sequence_frame(walking(), options, number).value());
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(grid.origin[axis] + grid.voxel * box.min[axis], sampled.min[axis], grid.voxel);
      EXPECT_NEAR(grid.origin[axis] + grid.voxel * box.max[axis], sampled.max[axis], grid.voxel);
    }
  }
}

TEST(WriteFolder, replaces_only_known_folders_and_only_on_request) {
  const TemporaryFolder folder;
  const std::string place = (folder.path() / "out").string();
  const auto is_ours = [](std::string_view name) { return name.ends_with(".ours"); };
  const auto write = [&](bool force, const std::string& text) {
    return write_folder(place, force, is_ours, [&](const fs::path& where) {
      write_file(where / "a.ours", text);
      return Result<void>();
    });
  };
  ASSERT_TRUE(write(false, "1"));
  EXPECT_THAT(write(false, "2").error().message, HasSubstr("--force"));
  EXPECT_EQ(read_text(fs::path(place) / "a.ours"), "1");
  ASSERT_TRUE(write(true, "3"));
  EXPECT_EQ(read_text(fs::path(place) / "a.ours"), "3");
  write_file(fs::path(place) / "diary.txt", "dear");
  EXPECT_THAT(write(true, "4").error().message, HasSubstr("diary.txt"));
  EXPECT_EQ(contents(place).size(), 2u);
}

TEST(WriteFolder, leaves_nothing_behind_when_it_fails) {
  const TemporaryFolder folder;
  const auto failed =
      write_folder((folder.path() / "out").string(), false, [](std::string_view) { return true; },
                   [](const fs::path& where) -> Result<void> {
                     write_file(where / "half", "");
                     return fail("the disk is full");
                   });
  EXPECT_EQ(failed.error().message, "the disk is full");
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST(WriteSequence, replaces_only_folders_of_its_own_frames) {
  const TemporaryFolder folder;
  SequenceJob job = small_job(folder.path() / "new/out", Sampler::uniform);
  ASSERT_TRUE(write_sequence(walking(), job)) << "it makes the folders above";
  job.force = true;
  ASSERT_TRUE(write_sequence(walking(), job));
  for (const char* foreign : {"frame_mine.ply", "frame_12.ply", "frame_.ply"}) {
    write_file(fs::path(job.output) / foreign, "mine");
    const auto refused = write_sequence(walking(), job);
    ASSERT_FALSE(refused);
    EXPECT_THAT(refused.error().message, HasSubstr(foreign));
    fs::remove(fs::path(job.output) / foreign);
  }
  fs::create_directory(fs::path(job.output) / "frame_0009.ply");
  EXPECT_FALSE(write_sequence(walking(), job));
}

TEST(WriteHard, writes_every_case_and_the_manifest) {
  const TemporaryFolder folder;
  const fs::path place = folder.path() / "hard";
  const auto written = write_hard(place.string(), false);
  ASSERT_TRUE(written) << written.error().message;
  const auto files = contents(place);
  const std::vector<HardCase> cases = hard_cases();
  EXPECT_EQ(*written, cases.size());
  EXPECT_EQ(files.size(), cases.size() + 1);
  for (const HardCase& c : cases) EXPECT_TRUE(files.at(c.file) == c.bytes) << c.file;
  EXPECT_EQ(files.at(kHardManifest), hard_manifest(cases));
  EXPECT_FALSE(write_hard(place.string(), false));
}

}  // namespace
}  // namespace pointreel::write_sequence_test
