#include "server/service/write_page.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/served_package.h"

namespace pointreel::write_page_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr PageFile kPage[] = {{"index.html", "<title>Pointreel</title>", "br", "gz"},
                              {"abc/page.js", "let", "", ""}};

std::string text_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(WritePage, puts_the_page_and_a_list_of_the_packages_beside_them) {
  const TemporaryFolder folder;
  write_package(folder / "walk", "base", "the rest");
  write_package(folder / "run", "base", "the rest");
  ASSERT_EQ(write_page(folder.path(), kPage, false).value().packages, 2u);
  EXPECT_EQ(text_of(folder / "index.html"), kPage[0].plain);
  EXPECT_EQ(text_of(folder / "index.html.br"), "br");
  EXPECT_EQ(text_of(folder / "index.html.gz"), "gz");
  EXPECT_EQ(text_of(folder / "page/abc/page.js"), "let");
  EXPECT_FALSE(fs::exists(folder / "page/abc/page.js.br"));
  auto list = nlohmann::json::parse(text_of(folder / "reels.json"));
  EXPECT_EQ(list["packages"][0]["manifest"], "/run/reel.json");
  // Again, with one package less and one that is damaged.
  fs::remove_all(folder / "run");
  write_package(folder / "damaged", "base", "the rest");
  fs::remove(folder / "damaged/0.base.prs");
  const WrittenPage again = write_page(folder.path(), kPage, false).value();
  EXPECT_EQ(again.packages, 1u);
  EXPECT_THAT(again.faults, testing::ElementsAre(HasSubstr("damaged")));
  list = nlohmann::json::parse(text_of(folder / "reels.json"));
  EXPECT_EQ(list["packages"][0]["manifest"], "/walk/reel.json");
}

TEST(WritePage, replaces_no_other_page) {
  const TemporaryFolder folder;
  write_package(folder / "walk", "base", "the rest");
  folder.write("index.html", "<title>My page</title>");
  EXPECT_THAT(write_page(folder.path(), kPage, false).error().message, HasSubstr("--force"));
  EXPECT_EQ(text_of(folder / "index.html"), "<title>My page</title>");
  EXPECT_FALSE(fs::exists(folder / "reels.json"));
  EXPECT_TRUE(write_page(folder.path(), kPage, true));
  EXPECT_EQ(text_of(folder / "index.html"), kPage[0].plain);
}

TEST(WritePage, lists_nothing_where_no_package_is_left_and_replaces_no_other_list) {
  const TemporaryFolder folder;
  write_package(folder / "walk", "base", "the rest");
  ASSERT_TRUE(write_page(folder.path(), kPage, false));
  fs::remove_all(folder / "walk");
  ASSERT_EQ(write_page(folder.path(), kPage, false).value().packages, 0u);
  EXPECT_TRUE(nlohmann::json::parse(text_of(folder / "reels.json"))["packages"].empty());
  folder.write("reels.json", R"({"mine": 1})");
  EXPECT_THAT(write_page(folder.path(), kPage, false).error().message, HasSubstr("--force"));
}

TEST(WritePage, says_what_is_not_a_folder_of_packages) {
  const TemporaryFolder folder;
  const auto error = [&](const fs::path& path) {
    return write_page(path, kPage, false).error().message;
  };
  EXPECT_THAT(error(folder / "none"), HasSubstr("is not a folder"));
  write_package(folder / "walk", "base", "the rest");
  EXPECT_THAT(error(folder / "walk"), HasSubstr("name the folder that holds the packages"));
  EXPECT_THAT(write_page(folder.path(), {}, false).error().message, HasSubstr("without the page"));
  folder.write("page", "a file");
  EXPECT_THAT(error(folder.path()), HasSubstr("page/abc: "));
  fs::remove(folder / "page");
  write_package(folder / "page", "base", "the rest");
  EXPECT_THAT(error(folder.path()), HasSubstr("page: is a package where the page is to lie"));
}

}  // namespace
}  // namespace pointreel::write_page_test
