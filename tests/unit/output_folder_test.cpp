#include "server/pack/output_folder.h"

#include <filesystem>
#include <optional>
#include <string>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/packed_clouds.h"

namespace pointreel {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

const OutputFolder::MayReplace kReplaceAll = [](const fs::path&) { return Result<void>(); };

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
    EXPECT_THAT(late.error().message, StartsWith(final.string() + ": "));
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
  const fs::path final = parent.path() / "out";
  fs::create_directory(final);
  write_file(final / "old", "1");
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
  const fs::path final = parent.path() / "out";
  fs::create_directory(final);
  write_file(final / "old", "1");
  fs::path asked;
  const auto folder = OutputFolder::create(final, [&](const fs::path& path) -> Result<void> {
    asked = path;
    return fail("is precious");
  });
  EXPECT_EQ(error_of(folder), final.string() + ": is precious");
  EXPECT_EQ(asked, final);
  EXPECT_THAT(names_in(parent.path()), ElementsAre("out"));
}

TEST(OutputFolder, refuses_a_place_in_a_missing_folder) {
  const TemporaryFolder parent;
  EXPECT_THAT(error_of(OutputFolder::create(parent.path() / "no/out")),
              StartsWith((parent.path() / "no").string() + ": "));
  EXPECT_THAT(error_of(OutputFolder::create("/")), StartsWith("/: "));
  EXPECT_THAT(names_in(parent.path()), IsEmpty());
}

}  // namespace
}  // namespace pointreel
