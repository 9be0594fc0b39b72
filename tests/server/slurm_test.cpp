// Packing through Slurm, with programs in the place of Slurm's that say what a test wants to hear.
// tests/cluster has a real one.

#include "server/parts/slurm.h"

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/commands/pack_arguments.h"
#include "server/parts/pack_part.h"
#include "tests/packed_reel.h"

namespace pointreel::slurm_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

class Slurm : public PackTest {
 protected:
  void SetUp() override {
    write_frames(6);
    fs::create_directories(programs_);
    ::setenv("PATH", (programs_.string() + ":" + path_).c_str(), 1);
    Result<PackOptions> options = parse_pack_command_line({});
    ASSERT_TRUE(options) << options.error().message;
    options_ = *options;
    options_.inputs = {frames_};
    options_.output = reel_;
    options_.segment_frames = 2;
    options_.threads = 1;
    const Result<MadePlan> made = make_plan(options_, {});
    ASSERT_TRUE(made) << made.error().message;
    plan_ = *read_plan(reel_);
    slurm_.output = reel_;
    slurm_.parts = 3;
    slurm_.look_every = std::chrono::milliseconds(1);
  }
  void TearDown() override { ::setenv("PATH", path_.c_str(), 1); }

  /// A program that writes its arguments to `calls`, and then does what a shell does with `script`.
  void program(const std::string& name, const std::string& script) {
    const fs::path path = programs_ / name;
    std::ofstream(path) << fmt::format("#!/bin/sh\necho {} \"$@\" >>'{}'\n{}\n", name,
                                       calls_.string(), script);
    fs::permissions(path, fs::perms::owner_all);
  }
  /// sbatch gives the array the number 7, and the join the number 8.
  void sbatch_succeeds(const std::string& cluster = "") {
    program("sbatch",
            fmt::format("case \"$*\" in *--array*) echo '7{0}';; *) echo '8{0}';; esac", cluster));
  }
  void log(const std::string& name, const std::string& text) {
    std::ofstream(parts_folder(reel_) / name) << text;
  }
  Result<void> wait(const SlurmJobs& jobs) {
    return wait_for_slurm(plan_, slurm_, jobs, [](std::uint32_t) {}, {});
  }
  std::string calls() const { return read_text(calls_); }

  const std::string path_ = std::getenv("PATH");
  const fs::path programs_ = reel_.parent_path() / "programs";
  const fs::path calls_ = reel_.parent_path() / "calls";
  PackOptions options_;
  PackPlan plan_;
  SlurmOptions slurm_;
};

TEST_F(Slurm, has_the_join_wait_for_the_parts) {
  sbatch_succeeds();
  slurm_.sbatch = {"--partition=night"};
  const Result<SlurmJobs> jobs = submit_to_slurm(plan_, slurm_);
  ASSERT_TRUE(jobs) << jobs.error().message;
  EXPECT_EQ(jobs->parts, "7");
  EXPECT_EQ(jobs->join, "8");
  EXPECT_EQ(jobs->cluster, "");
  EXPECT_THAT(calls(), HasSubstr("--array=1-3"));
  EXPECT_THAT(calls(), HasSubstr("--partition=night --dependency=afterok:7"));
  EXPECT_THAT(calls(), Not(HasSubstr("--clusters")));
}

TEST_F(Slurm, asks_the_cluster_that_took_the_jobs) {
  sbatch_succeeds(";north");
  program("squeue", "echo 'slurm_load_jobs error: Invalid job id specified' >&2; exit 1");
  slurm_.sbatch = {"--clusters=south,north"};
  const Result<SlurmJobs> jobs = submit_to_slurm(plan_, slurm_);
  ASSERT_TRUE(jobs) << jobs.error().message;
  EXPECT_EQ(jobs->parts, "7");
  EXPECT_EQ(jobs->cluster, "north");
  EXPECT_THAT(calls(), HasSubstr("--clusters=north --dependency=afterok:7"));
  EXPECT_FALSE(wait(*jobs));
  EXPECT_THAT(calls(), HasSubstr("squeue --clusters=north --noheader"));
}

TEST_F(Slurm, names_sbatch_if_it_says_nothing) {
  for (const auto& [script, status] : {std::pair("exit 3", "3"), std::pair("exit 0", "0")}) {
    program("sbatch", script);
    const Result<SlurmJobs> jobs = submit_to_slurm(plan_, slurm_);
    ASSERT_FALSE(jobs);
    EXPECT_THAT(jobs.error().message, HasSubstr(std::string("sbatch ended with status ") + status));
  }
}

TEST_F(Slurm, takes_back_the_parts_if_the_join_is_refused) {
  program("sbatch",
          "case \"$*\" in *--array*) echo '7;north'; exit;; esac\n"
          "echo 'sbatch: warning: it is late' >&2; echo 'sbatch: error: no more jobs' >&2; exit 1");
  program("scancel", "");
  const Result<SlurmJobs> jobs = submit_to_slurm(plan_, slurm_);
  ASSERT_FALSE(jobs);
  EXPECT_THAT(jobs.error().message, HasSubstr("it is late; sbatch: error: no more jobs"));
  EXPECT_THAT(calls(), HasSubstr("scancel --clusters=north 7"));
}

TEST_F(Slurm, waits_while_the_jobs_are_there_or_squeue_fails) {
  sbatch_succeeds();
  // 70 and 71 are others' jobs.
  program("squeue", fmt::format("case $(grep -c squeue '{}') in\n"
                                "1) echo 'squeue: error: timed out' >&2; exit 1;;\n"
                                "2) echo 'squeue: warning: slow'; echo '7_[2-3]';;\n"
                                "3) echo 8;;\n"
                                "*) echo 70; echo 71_1;;\n"
                                "esac",
                                calls_.string()));
  const Result<SlurmJobs> jobs = submit_to_slurm(plan_, slurm_);
  ASSERT_TRUE(jobs) << jobs.error().message;
  EXPECT_FALSE(wait(*jobs));
  std::size_t asked = 0;
  for (std::size_t at = calls().find("squeue "); at != std::string::npos;
       at = calls().find("squeue ", at + 1))
    ++asked;
  EXPECT_EQ(asked, 4u);
}

TEST_F(Slurm, tells_the_error_of_a_part_that_is_missing) {
  log("part-3.log", "pointreel-server: that was yesterday\n");
  log("join.log", "pointreel-server: that, too\n");
  sbatch_succeeds();
  program("squeue", "");
  const Result<SlurmJobs> jobs = submit_to_slurm(plan_, slurm_);
  ASSERT_TRUE(jobs) << jobs.error().message;
  EXPECT_THAT(wait(*jobs).error().message, HasSubstr("no job has written an error"));
  // The first part's second try succeeds.
  log("part-1.log", "pointreel-server: a node was lost\n");
  ASSERT_TRUE(pack_part(plan_, options_, {1, 3}, false));
  log("part-2.log", "pointreel-server: frame3.ply: is damaged\n");
  const Result<void> done = wait(*jobs);
  ASSERT_FALSE(done);
  EXPECT_THAT(done.error().message, HasSubstr("2 of 6 frames are packed; part 2: frame3.ply"));
}

}  // namespace
}  // namespace pointreel::slurm_test
