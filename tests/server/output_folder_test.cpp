#include "common/file_system/output_folder.h"

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "tests/packed_clouds.h"

namespace pointreel::output_folder_test {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

const OutputFolder::MayReplace kReplaceAll = [](const fs::path&) { return Result<void>(); };

/// A folder "out" that is there already, with a file "old" in it.
fs::path make_old_folder(const TemporaryFolder& parent) {
  const fs::path folder = parent.path() / "out";
  fs::create_directory(folder);
  write_file(folder / "old", "1");
  return folder;
}

std::string error_of(const Result<OutputFolder>& folder) {
  return folder ? "made" : folder.error().message;
}

TEST(OutputFolder, does_not_appear_before_it_is_published) {
  const TemporaryFolder parent;
  const fs::path final = parent.path() / "out";
  Result<OutputFolder> folder = OutputFolder::create(final);
  ASSERT_TRUE(folder) << folder.error().message;
  EXPECT_EQ(folder->path().parent_path(), parent.path());
  EXPECT_THAT(folder->path().filename().string(), StartsWith("."));
  write_file(folder->path() / "a", "1");
  EXPECT_FALSE(fs::exists(final));

  ASSERT_TRUE(folder->publish());
  EXPECT_EQ(read_text(final / "a"), "1");
  EXPECT_THAT(names_in(parent.path()), ElementsAre("out"));
}

TEST(OutputFolder, disappears_if_it_is_never_published) {
  const TemporaryFolder parent;
  {
    Result<OutputFolder> folder = OutputFolder::create(parent.path() / "out");
    ASSERT_TRUE(folder) << folder.error().message;
    fs::create_directory(folder->path() / "deep");
    write_file(folder->path() / "deep" / "a", "1");
  }
  EXPECT_THAT(names_in(parent.path()), IsEmpty());
}

TEST(OutputFolder, stays_published_after_its_destruction) {
  const TemporaryFolder parent;
  {
    Result<OutputFolder> folder = OutputFolder::create(parent.path() / "out");
    ASSERT_TRUE(folder && folder->publish());
  }
  EXPECT_THAT(names_in(parent.path()), ElementsAre("out"));
}

TEST(OutputFolder, belongs_to_the_object_that_it_was_last_moved_to) {
  const TemporaryFolder parent;
  std::optional<Result<OutputFolder>> first(OutputFolder::create(parent.path() / "out"));
  ASSERT_TRUE(*first);
  OutputFolder second = std::move(**first);
  first.reset();
  EXPECT_TRUE(fs::is_directory(second.path()));
  ASSERT_TRUE(second.publish());
  EXPECT_THAT(names_in(parent.path()), ElementsAre("out"));
}

TEST(OutputFolder, keeps_the_first_of_two_folders_published_to_one_place) {
  const TemporaryFolder parent;
  const fs::path final = parent.path() / "out";
  {
    Result<OutputFolder> first = OutputFolder::create(final);
    Result<OutputFolder> second = OutputFolder::create(final);
    ASSERT_TRUE(first && second);
    EXPECT_NE(first->path(), second->path());
    write_file(first->path() / "a", "first");
    write_file(second->path() / "a", "second");
    ASSERT_TRUE(second->publish());
    const Result<void> late = first->publish();
    ASSERT_FALSE(late);
    EXPECT_EQ(late.error().message, final.string() + ": another program has written it meanwhile");
  }
  EXPECT_EQ(read_text(final / "a"), "second");
  EXPECT_THAT(names_in(parent.path()), ElementsAre("out"));
}

TEST(OutputFolder, replaces_an_empty_folder) {
  const TemporaryFolder parent;
  fs::create_directory(parent.path() / "out");
  Result<OutputFolder> folder = OutputFolder::create(parent.path() / "out/");
  ASSERT_TRUE(folder) << folder.error().message;
  write_file(folder->path() / "a", "1");
  ASSERT_TRUE(folder->publish());
  EXPECT_EQ(read_text(parent.path() / "out/a"), "1");
}

TEST(OutputFolder, refuses_an_existing_folder_that_is_not_empty) {
  const TemporaryFolder parent;
  fs::create_directory(parent.path() / "folder");
  write_file(parent.path() / "folder/a", "1");
  write_file(parent.path() / "file", "1");
  fs::create_symlink("folder", parent.path() / "link");
  for (const char* name : {"folder", "file", "link"}) {
    EXPECT_THAT(error_of(OutputFolder::create(parent.path() / name)),
                StartsWith((parent.path() / name).string() + ": exists"));
  }
  for (const char* name : {"file", "link"}) {
    EXPECT_THAT(error_of(OutputFolder::create(parent.path() / name, kReplaceAll)),
                HasSubstr("is not a folder"));
  }
  EXPECT_EQ(read_text(parent.path() / "folder/a"), "1");
  EXPECT_THAT(names_in(parent.path()), ElementsAre("file", "folder", "link"));
}

TEST(OutputFolder, replaces_a_folder_only_if_allowed_and_only_when_published) {
  const TemporaryFolder parent;
  const fs::path final = make_old_folder(parent);
  {
    Result<OutputFolder> folder = OutputFolder::create(final, kReplaceAll);
    ASSERT_TRUE(folder) << folder.error().message;
    EXPECT_EQ(read_text(final / "old"), "1");
  }
  EXPECT_THAT(names_in(final), ElementsAre("old"));
  {
    Result<OutputFolder> folder = OutputFolder::create(final, kReplaceAll);
    ASSERT_TRUE(folder) << folder.error().message;
    write_file(folder->path() / "new", "2");
    ASSERT_TRUE(folder->publish());
    EXPECT_THAT(names_in(final), ElementsAre("new"));
  }
  EXPECT_THAT(names_in(parent.path()), ElementsAre("out"));
}

TEST(OutputFolder, asks_before_it_replaces_a_folder) {
  const TemporaryFolder parent;
  const fs::path final = make_old_folder(parent);
  fs::path asked;
  const auto folder = OutputFolder::create(final, [&](const fs::path& path) -> Result<void> {
    asked = path;
    return fail("is precious");
  });
  EXPECT_EQ(error_of(folder), final.string() + ": is precious");
  EXPECT_EQ(asked, final);
  EXPECT_THAT(names_in(parent.path()), ElementsAre("out"));
}

TEST(OutputFolder, makes_the_folders_above_it_and_removes_them_if_it_is_never_published) {
  const TemporaryFolder parent;
  fs::create_directory(parent.path() / "there");
  for (const bool publish : {false, true}) {
    EXPECT_THAT(names_in(parent.path() / "there"), IsEmpty());
    Result<OutputFolder> folder = OutputFolder::create(parent.path() / "there/a/b/out/");
    ASSERT_TRUE(folder) << folder.error().message;
    write_file(folder->path() / "a", "1");
    if (publish) {
      ASSERT_TRUE(folder->publish());
    }
  }
  EXPECT_EQ(read_text(parent.path() / "there/a/b/out/a"), "1");
}

TEST(OutputFolder, refuses_places_that_cannot_be_folders) {
  const TemporaryFolder parent;
  write_file(parent.path() / "file", "1");
  EXPECT_THAT(error_of(OutputFolder::create(parent.path() / "file/out")),
              StartsWith((parent.path() / "file").string() + ": "));
  EXPECT_THAT(error_of(OutputFolder::create("/")), StartsWith("/: "));
  EXPECT_THAT(names_in(parent.path()), ElementsAre("file"));
}

TEST(OutputFolder, replaces_nothing_but_files) {
  const TemporaryFolder parent;
  const fs::path final = parent.path() / "out";
  fs::create_directories(final / "folder");
  fs::create_symlink("nowhere", final / "link");
  for (const char* name : {"folder", "link"}) {
    EXPECT_THAT(error_of(OutputFolder::create(final, kReplaceAll)), HasSubstr("not a plain file"));
    fs::remove(final / name);
    write_file(final / name, "1");
  }
  EXPECT_TRUE(OutputFolder::create(final, kReplaceAll));
}

TEST(OutputFolder, keeps_what_came_into_the_old_folder_meanwhile) {
  const TemporaryFolder parent;
  const fs::path final = make_old_folder(parent);
  {
    Result<OutputFolder> folder = OutputFolder::create(final, kReplaceAll);
    ASSERT_TRUE(folder) << folder.error().message;
    write_file(folder->path() / "new", "2");
    fs::create_directory(final / "mine");
    write_file(final / "mine/a", "3");
    const Result<void> published = folder->publish();
    ASSERT_FALSE(published);
    EXPECT_THAT(published.error().message, HasSubstr("mine"));
  }
  EXPECT_THAT(names_in(final), ElementsAre("mine", "old"));
  EXPECT_EQ(read_text(final / "mine/a"), "3");
  EXPECT_THAT(names_in(parent.path()), ElementsAre("out"));
}

TEST(OutputFolder, what_a_killed_program_left_behind_is_removed_and_nothing_else) {
  const TemporaryFolder parent;
  const fs::path final = parent.path() / "out";
  // The program that dies is this one, run again from the start of this test. A mere fork could
  // wait forever for a lock of the allocator that another thread held.
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const char* variable = "POINTREEL_TEST_DIES_WRITING";
  ::setenv(variable, final.c_str(), 0);
  EXPECT_EXIT(
      {
        fs::remove(parent.path());
        Result<OutputFolder> folder = OutputFolder::create(std::getenv(variable));
        if (folder) write_file(folder->path() / "half", "1");
        ::_exit(folder ? 0 : 1);  // without any destructor
      },
      testing::ExitedWithCode(0), "");
  ::unsetenv(variable);
  ASSERT_EQ(names_in(parent.path()).size(), 1u);
  write_file(parent.path() / ".out.partial-file", "mine");
  write_file(parent.path() / ".other.partial-1-0", "mine");
  {
    Result<OutputFolder> first = OutputFolder::create(final);
    Result<OutputFolder> second = OutputFolder::create(final);
    ASSERT_TRUE(first && second);
    EXPECT_TRUE(fs::exists(first->path())) << "the second must not take it for abandoned";
    ASSERT_TRUE(first->publish());
  }
  EXPECT_THAT(names_in(parent.path()),
              ElementsAre(".other.partial-1-0", ".out.partial-file", "out"));
}

TEST(OutputFolder, many_programs_at_once_leave_one_whole_folder) {
  const TemporaryFolder parent;
  const fs::path final = parent.path() / "out";
  std::vector<std::jthread> programs;
  for (int i = 0; i < 8; ++i) {
    programs.emplace_back([&, i] {
      for (int round = 0; round < 100; ++round) {
        Result<OutputFolder> folder = OutputFolder::create(final, kReplaceAll);
        if (!folder) continue;
        write_file(folder->path() / "a", std::to_string(i));
        write_file(folder->path() / "b", std::to_string(i));
        write_file(folder->path() / ("of-" + std::to_string(i)), "");
        if (round % 3 == 0) continue;
        EXPECT_TRUE(folder->publish() || fs::exists(final));
      }
    });
  }
  programs.clear();
  EXPECT_EQ(read_text(final / "a"), read_text(final / "b"));
  EXPECT_THAT(names_in(final), ElementsAre("a", "b", "of-" + read_text(final / "a")));
  EXPECT_THAT(names_in(parent.path()), ElementsAre("out"));
}

}  // namespace
}  // namespace pointreel::output_folder_test
