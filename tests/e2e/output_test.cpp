// Every program notices that its standard output cannot be written.

#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codec/files/ply.h"
#include "tests/e2e/process.h"
#include "tests/paths.h"
#include "tests/temporary_folder.h"

namespace pointreel::e2e::output_test {
namespace {

namespace fs = std::filesystem;

/// Runs a program whose standard output is a full disk.
Outcome run_into_full_disk(const std::string& program, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(),
                   {"-c", "exec \"$@\" > /dev/full", "sh", program_folder() / program});
  return run("/bin/sh", arguments);
}

TEST(Output, a_full_standard_output_is_an_error_of_every_program) {
  const TemporaryFolder folder;
  PointCloud cloud;
  for (int i = 0; i < 100; ++i) cloud.positions.emplace_back(0.01f * static_cast<float>(i), 0, 0);
  fs::create_directories(folder / "in");
  ASSERT_TRUE(write_ply(folder / "in" / "0.ply", cloud));
  const std::string in = (folder / "in").string(), reel = (folder / "reel").string();
  const std::string back = (folder / "back").string(), synth = (folder / "synth").string();
  ASSERT_EQ(run("pointreel-server", {"pack", "-i", in, "-o", reel}).exit_code, 0);
  const std::vector<std::vector<std::string>> commands = {
      {"pointreel-server", "--help"},
      {"pointreel-server", "pack", "--help"},
      {"pointreel-server", "info", reel},
      {"pointreel-server", "info", reel, "--json"},
      {"pointreel-server", "verify", reel},
      {"pointreel-server", "verify", reel, "--json"},
      {"pointreel-server", "unpack", "-i", reel, "-o", back},
      {"pointreel-server", "pack", "-i", in, "-o", reel, "--force"},
      {"pointreel-server", "pack", "-i", in, "-o", reel, "--force", "--json"},
      {"pointreel", "--version"},
      {"pointreel", "play", "--help"},
      {"pointreel", "play", reel, "--offscreen", "16x16", "--json", "-"},
      {"pointreel-synth", "--list"},
      {"pointreel-synth", "--help"},
      {"pointreel-synth", "walk", "--frames", "1", "--points", "100", "--sampler", "uniform", "-o",
       synth},
      {"pointreel-link", "--help"},
      {"pointreel-load", "--help"}};
  for (const std::vector<std::string>& command : commands) {
    const Outcome outcome = run_into_full_disk(command[0], {command.begin() + 1, command.end()});
    EXPECT_EQ(outcome.exit_code, 1) << testing::PrintToString(command);
    EXPECT_THAT(outcome.err, testing::HasSubstr("standard output cannot be written"))
        << testing::PrintToString(command);
  }
}

TEST(Output, a_limit_on_the_size_of_files_is_an_error_and_kills_no_program) {
  const TemporaryFolder folder;
  PointCloud cloud;
  for (int i = 0; i < 20'000; ++i) {
    cloud.positions.emplace_back(i % 141, i / 141, i * 7919 % 100);
    cloud.colors.emplace_back(257 * (i % 256), 257 * (i / 256), 0);
  }
  fs::create_directories(folder / "in");
  ASSERT_TRUE(write_ply(folder / "in" / "0.ply", cloud));
  const std::string in = (folder / "in").string(), reel = (folder / "reel").string();
  ASSERT_EQ(run("pointreel-server", {"pack", "-i", in, "-o", reel}).exit_code, 0);
  const auto output = [&](const char* name) { return (folder / name).string(); };
  const std::vector<std::vector<std::string>> commands = {
      {"pointreel-server", "pack", "-i", in, "-o", output("package")},
      {"pointreel-server", "unpack", "-i", reel, "-o", output("back")},
      {"pointreel", "play", reel, "--offscreen", "256x256", "--screenshot", output("a.png")},
      {"pointreel-synth", "walk", "--frames", "1", "-o", output("synth")}};
  for (const std::vector<std::string>& command : commands) {
    std::vector<std::string> arguments = {"-c", "ulimit -f 8; exec \"$@\"", "sh"};
    arguments.push_back(program_folder() / command[0]);
    arguments.insert(arguments.end(), command.begin() + 1, command.end());
    const Outcome outcome = run("/bin/sh", arguments);
    EXPECT_EQ(outcome.exit_code, 1) << testing::PrintToString(command);
    EXPECT_THAT(outcome.err, testing::HasSubstr("cannot be written"))
        << testing::PrintToString(command);
    EXPECT_FALSE(fs::exists(command.back())) << testing::PrintToString(command);
  }
}

TEST(Output, seeds_that_are_no_numbers_of_64_bits_are_refused) {
  const TemporaryFolder folder;
  for (const char* seed : {"-1", "18446744073709551616", "1.5", ""}) {
    const Outcome outcome =
        run("pointreel-synth", {"walk", "--seed", seed, "-o", (folder.path() / "out").string()});
    EXPECT_EQ(outcome.exit_code, 2) << seed;
    EXPECT_THAT(outcome.err, testing::HasSubstr("--seed")) << seed;
  }
  const Outcome largest =
      run("pointreel-synth", {"walk", "--seed", "18446744073709551615", "--frames", "1", "--points",
                              "100", "-o", (folder.path() / "out").string()});
  EXPECT_EQ(largest.exit_code, 0) << largest.err;
}

}  // namespace
}  // namespace pointreel::e2e::output_test
