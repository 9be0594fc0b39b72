// Which files of which folders can be fetched.

#include "server/service/catalog.h"

#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/served_package.h"
#include "tests/unprivileged.h"

namespace pointreel::catalog_test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

class CatalogTest : public testing::Test {
 protected:
  CatalogTest() { write_package(reel_, "base", "the rest"); }

  std::string error_of(const std::vector<fs::path>& folders) {
    const auto catalog = Catalog::load(folders);
    if (catalog) return "loaded";
    EXPECT_EQ(catalog.error().message.find('\n'), std::string::npos);
    return catalog.error().message;
  }

  static std::vector<std::string> names_in(const std::vector<fs::path>& folders) {
    std::vector<std::string> names;
    // In the head of the loop, the result would be gone before the loop begins.
    const std::vector<PackageFolder> packages = packages_in(folders).value();
    for (const PackageFolder& package : packages) names.push_back(package.name);
    return names;
  }

  TemporaryFolder temporary_;
  fs::path reel_ = temporary_.path() / "walk";
};

TEST_F(CatalogTest, holds_only_the_files_that_the_manifest_names) {
  write_file(reel_ / "notes.txt", "private");
  fs::create_directory(reel_ / "sub");
  write_file(reel_ / "sub" / "0.base.prs", "base");
  const auto catalog = Catalog::load({reel_});
  ASSERT_TRUE(catalog) << catalog.error().message;
  for (const char* path :
       {"/healthz", "/walk", "/walk/", "/walk/reel.json", "/walk/0.base.prs", "/walk/0.full.prs"}) {
    EXPECT_NE(catalog->find(path), nullptr) << path;
  }
  for (const char* path : {"", "walk", "/walk/notes.txt", "/walk/sub", "/walk/sub/0.base.prs",
                           "/0.base.prs", "/walk//0.base.prs", "/walk/0.base", "/WALK",
                           "/walk/../walk/reel.json", "/walk/reel.json/"}) {
    EXPECT_EQ(catalog->find(path), nullptr) << path;
  }
  const Resource& base = *catalog->find("/walk/0.base.prs");
  EXPECT_EQ(base.kind, Resource::Kind::kFile);
  EXPECT_EQ(base.size, 4u);
  EXPECT_EQ(base.file, fs::canonical(reel_) / "0.base.prs");
}

TEST_F(CatalogTest, lists_when_packages_were_captured) {
  Manifest manifest = read_manifest(reel_).value();
  const auto listed = [&] {
    write_file(reel_ / kManifestName, write_manifest(manifest));
    return nlohmann::json::parse(Catalog::load({reel_}).value().list({})->text).at("packages")[0];
  };
  EXPECT_FALSE(listed().contains("captured_us"));
  manifest.captured_us = 1'781'280'005'250'000;
  EXPECT_EQ(listed().at("captured_us"), 1'781'280'005'250'000);
}

TEST_F(CatalogTest, lists_the_packages) {
  write_package(temporary_.path() / "a b", "1", "22");
  const auto catalog = Catalog::load({reel_, temporary_.path() / "a b"});
  ASSERT_TRUE(catalog) << catalog.error().message;
  const auto listing = nlohmann::json::parse(catalog->list({})->text).at("packages");
  ASSERT_EQ(listing.size(), 2u);
  EXPECT_EQ(listing[0].at("name"), "walk");
  EXPECT_EQ(listing[0].at("url"), "/walk");
  EXPECT_EQ(listing[0].at("manifest"), "/walk/reel.json");
  EXPECT_EQ(listing[0].at("frames"), 1);
  EXPECT_EQ(listing[0].at("fps"), 25.0);
  EXPECT_EQ(listing[0].at("codec"), "octree");
  EXPECT_EQ(listing[0].at("bytes"), 4 + 8 + fs::file_size(reel_ / "reel.json"));
  EXPECT_EQ(listing[1].at("name"), "a b");
  EXPECT_EQ(listing[1].at("url"), "/a%20b");
}

TEST_F(CatalogTest, lists_live_streams_beside_the_packages) {
  StreamStatistics stream;
  stream.name = "stage";
  stream.publishing = true;
  stream.viewers = 3;
  const auto both = nlohmann::json::parse(
      Catalog::load({reel_})->list([&] { return std::vector{stream}; })->text);
  EXPECT_EQ(both.at("packages").size(), 1u);
  ASSERT_EQ(both.at("streams").size(), 1u);
  EXPECT_EQ(both["streams"][0], (nlohmann::json{{"name", "stage"},
                                                {"url", "/live/stage"},
                                                {"manifest", "/live/stage/reel.json"},
                                                {"publishing", true},
                                                {"viewers", 3}}));
  const auto none = nlohmann::json::parse(Catalog().list({})->text);
  EXPECT_EQ(none, (nlohmann::json{{"packages", nlohmann::json::array()},
                                  {"streams", nlohmann::json::array()}}));
}

TEST_F(CatalogTest, names_a_package_after_its_folder_however_the_path_is_written) {
  const fs::path before = fs::current_path();
  fs::current_path(reel_);
  const auto here = Catalog::load({"."});
  fs::current_path(before);
  ASSERT_TRUE(here) << here.error().message;
  EXPECT_NE(here->find("/walk/reel.json"), nullptr);
  const auto slash = Catalog::load({reel_ / ""});
  ASSERT_TRUE(slash) << slash.error().message;
  EXPECT_NE(slash->find("/walk/reel.json"), nullptr);
}

TEST_F(CatalogTest, takes_a_folder_of_packages_for_the_packages_in_it) {
  const fs::path folder = temporary_.path() / "all";
  for (const char* name : {"b10", "b9", ".b8"}) write_package(folder / name, "1", "2");
  fs::create_directory(folder / "notes");
  EXPECT_THAT(names_in({folder, reel_}), ElementsAre("b9", "b10", "walk"));
  EXPECT_THAT(names_in({folder / "notes"}), ElementsAre()) << "there may be packages later";
  write_file(folder / "notes" / "1.ply", "ply");
  EXPECT_THAT(names_in({folder / "notes", folder / "missing"}), ElementsAre("notes", "missing"))
      << "these are mistakes";
}

TEST_F(CatalogTest, names_packages_in_folders_by_their_path) {
  const fs::path all = temporary_.path() / "all";
  for (const char* name : {"a/x y/z", "a/b", "a/b/inside", ".hidden/c", "live/d", "page/e"})
    write_package(all / name, "1", "2");
  fs::create_directory_symlink(all, all / "a" / "around");
  EXPECT_THAT(names_in({all}), ElementsAre("a/b", "a/x y/z"));
  fs::path deep = all;
  for (int i = 0; i < kMaxFolderDepth; ++i) deep /= "d";
  write_package(deep / "e", "1", "2");
  EXPECT_THAT(names_in({all}), ElementsAre("a/b", "a/x y/z"));
  write_package(deep, "1", "2");
  EXPECT_THAT(names_in({all}), ElementsAre("a/b", "a/x y/z", "d/d/d/d/d/d/d/d"));
  const auto catalog = Catalog::load({all});
  ASSERT_TRUE(catalog) << catalog.error().message;
  ASSERT_NE(catalog->find("/a/x y/z"), nullptr);
  EXPECT_EQ(catalog->find("/a/x y/z")->text, "/a/x%20y/z/reel.json");
  EXPECT_NE(catalog->find("/a/x y/z/0.base.prs"), nullptr);
  for (const char* path : {"/a", "/a/x y", "/a/around/a/b/reel.json", "/live/d/reel.json"})
    EXPECT_EQ(catalog->find(path), nullptr) << path;
}

TEST_F(CatalogTest, packages_appear_change_and_vanish_while_they_are_served) {
  const fs::path all = temporary_.path() / "all";
  write_package(all / "one", "1", "2");
  auto catalog = Catalog::load({all, reel_}).value();
  const Catalog served = catalog;
  const auto list = [&] {
    std::vector<std::string> names;
    const auto served_list = nlohmann::json::parse(served.list({})->text);
    for (const auto& package : served_list.at("packages")) names.push_back(package.at("name"));
    return names;
  };
  EXPECT_THAT(catalog.refresh({all, reel_}).changes, ElementsAre());
  EXPECT_THAT(list(), ElementsAre("one", "walk"));
  const auto kept = served.find("/one/0.base.prs");

  write_package(all / "sub" / "two", "22", "3");
  EXPECT_THAT(catalog.refresh({all, reel_}).changes, ElementsAre(HasSubstr("two: is served now")));
  EXPECT_THAT(list(), ElementsAre("one", "sub/two", "walk"));
  EXPECT_NE(served.find("/sub/two/0.base.prs"), nullptr);
  EXPECT_EQ(served.find("/one/0.base.prs"), kept) << "what has not changed is not read again";

  fs::remove_all(all / "one");
  write_package(reel_, "another base", "the rest");
  EXPECT_THAT(catalog.refresh({all, reel_}).changes, ElementsAre("one: is no longer served"));
  EXPECT_THAT(list(), ElementsAre("sub/two", "walk"));
  EXPECT_EQ(served.find("/one/0.base.prs"), nullptr);
  EXPECT_EQ(served.find("/walk/0.base.prs")->size, 12u);

  // While a package is being copied it is not complete.
  fs::remove(all / "sub" / "two" / "0.full.prs");
  write_file(all / "sub" / "two" / "reel.json",
             write_manifest(small_manifest("22", "333 333 333")));
  const auto news = catalog.refresh({all, reel_});
  EXPECT_THAT(news.faults, ElementsAre(HasSubstr("0.full.prs: No such file")));
  EXPECT_THAT(list(), ElementsAre("walk"));
  EXPECT_THAT(catalog.refresh({all, reel_}).faults, ElementsAre()) << "it is said once";
  write_file(all / "sub" / "two" / "0.full.prs", "333 333 333");
  EXPECT_THAT(catalog.refresh({all, reel_}).changes, ElementsAre(HasSubstr("is served now")));
  EXPECT_THAT(list(), ElementsAre("sub/two", "walk"));

  fs::remove_all(all);
  fs::remove_all(reel_);
  EXPECT_EQ(catalog.refresh({all, reel_}).changes.size(), 2u);
  EXPECT_THAT(list(), ElementsAre());
  EXPECT_NE(served.find("/healthz"), nullptr);
}

TEST_F(CatalogTest, a_fault_of_one_package_in_a_folder_keeps_the_others) {
  const fs::path all = temporary_.path() / "all";
  for (const char* name : {"good", "bad"}) write_package(all / name, "1", "2");
  write_file(all / "bad" / "reel.json", "{");
  auto catalog = Catalog::load({all});
  ASSERT_TRUE(catalog) << catalog.error().message;
  EXPECT_NE(catalog->find("/good/reel.json"), nullptr);
  EXPECT_EQ(catalog->find("/bad/reel.json"), nullptr);
  EXPECT_THAT(catalog->refresh({all}).faults, ElementsAre(HasSubstr("bad/reel.json")));
  // Its name could not be part of a URL.
  write_package(all / "a\\b", "1", "2");
  EXPECT_THAT(catalog->refresh({all}).faults, ElementsAre(HasSubstr("rename it")));
  fs::remove_all(all / "a\\b");
  // Two of the same name, one of which came later.
  write_package(temporary_.path() / "more" / "good", "3", "4");
  const auto news = catalog->refresh({all, temporary_.path() / "more"});
  EXPECT_THAT(news.faults, ElementsAre(HasSubstr("another package is named 'good'")));
  EXPECT_EQ(catalog->find("/good/0.base.prs")->size, 1u);
}

TEST_F(CatalogTest, the_list_is_not_made_for_each_of_many_requests) {
  const auto catalog = Catalog::load({reel_}).value();
  int made = 0;
  const auto list = [&] {
    return catalog.list([&] {
      ++made;
      return std::vector<StreamStatistics>();
    });
  };
  const auto first = list();
  for (int i = 0; i < 10'000; ++i) EXPECT_EQ(list()->etag, first->etag);
  EXPECT_LT(made, 10'000);
}

TEST_F(CatalogTest, refuses_a_folder_that_is_not_a_package) {
  EXPECT_THAT(error_of({temporary_.path() / "missing"}), HasSubstr("missing: No such file"));
  fs::create_directory(temporary_.path() / "frames");
  write_file(temporary_.path() / "frames" / "1.ply", "ply");
  EXPECT_THAT(error_of({temporary_.path() / "frames"}), HasSubstr("holds no reel.json"));
  write_file(reel_ / "reel.json", "{");
  EXPECT_THAT(error_of({reel_}), HasSubstr("walk/reel.json"));
}

TEST_F(CatalogTest, refuses_two_folders_with_the_same_name) {
  write_package(temporary_.path() / "other" / "walk", "1", "2");
  EXPECT_THAT(error_of({reel_, temporary_.path() / "other" / "walk"}),
              AllOf(HasSubstr("other/walk"), HasSubstr("another package is named 'walk'")));
  EXPECT_THAT(error_of({reel_, reel_}), HasSubstr("another package"));
}

TEST_F(CatalogTest, refuses_an_incomplete_package) {
  write_file(reel_ / "0.full.prs", "the res");
  EXPECT_THAT(error_of({reel_}),
              HasSubstr("0.full.prs: has 7 bytes, the manifest says 8; pack it again"));
  fs::remove(reel_ / "0.full.prs");
  EXPECT_THAT(error_of({reel_}), HasSubstr("0.full.prs: No such file"));
  fs::create_directory(reel_ / "0.full.prs");
  EXPECT_THAT(error_of({reel_}), HasSubstr("0.full.prs: is not a regular file"));
}

TEST_F(CatalogTest, refuses_symbolic_links_out_of_the_package_and_follows_those_within) {
  const fs::path outside = temporary_.path() / "outside";
  write_file(outside, "the rest");
  fs::remove(reel_ / "0.full.prs");
  fs::create_symlink(outside, reel_ / "0.full.prs");
  EXPECT_THAT(error_of({reel_}), HasSubstr("0.full.prs: is a symbolic link that leads out"));

  // This folder lies beside the package and has its name as a prefix.
  fs::create_directory(temporary_.path() / "walk2");
  write_file(temporary_.path() / "walk2" / "x", "the rest");
  fs::remove(reel_ / "0.full.prs");
  fs::create_symlink("../walk2/x", reel_ / "0.full.prs");
  EXPECT_THAT(error_of({reel_}), HasSubstr("leads out"));

  fs::remove(reel_ / "0.full.prs");
  write_file(reel_ / "real", "the rest");
  fs::create_symlink("real", reel_ / "0.full.prs");
  const auto catalog = Catalog::load({reel_});
  ASSERT_TRUE(catalog) << catalog.error().message;
  EXPECT_EQ(catalog->find("/walk/0.full.prs")->file, fs::canonical(reel_ / "real"));

  fs::rename(reel_ / "reel.json", temporary_.path() / "reel.json");
  fs::create_symlink("../reel.json", reel_ / "reel.json");
  EXPECT_THAT(error_of({reel_}), HasSubstr("reel.json: is a symbolic link that leads out"));
}

TEST_F(CatalogTest, does_not_open_a_file_that_was_changed_or_replaced) {
  const auto catalog = Catalog::load({reel_});
  ASSERT_TRUE(catalog) << catalog.error().message;
  const Resource& full = *catalog->find("/walk/0.full.prs");
  EXPECT_TRUE(open_resource(full));

  const auto modified = fs::last_write_time(full.file);
  write_file(full.file, "THE REST");
  fs::last_write_time(full.file, modified + std::chrono::seconds(1));
  EXPECT_EQ(open_resource(full).error(), OpenError::kChanged);

  // Neither its size nor the time of its last modification gives this one away.
  fs::last_write_time(full.file, modified);
  EXPECT_EQ(open_resource(full).error(), OpenError::kChanged);
  fs::remove(full.file);
  write_file(temporary_.path() / "other", "The Rest");
  fs::last_write_time(temporary_.path() / "other", modified);
  fs::rename(temporary_.path() / "other", full.file);
  EXPECT_EQ(open_resource(full).error(), OpenError::kChanged);

  write_file(full.file, "the res");
  fs::last_write_time(full.file, modified);
  EXPECT_EQ(open_resource(full).error(), OpenError::kChanged);

  // This file is put in its place after the server has started.
  fs::remove(full.file);
  write_file(temporary_.path() / "secret", "the rest");
  fs::last_write_time(temporary_.path() / "secret", modified);
  fs::create_symlink(temporary_.path() / "secret", full.file);
  EXPECT_EQ(open_resource(full).error(), OpenError::kChanged);

  fs::remove(full.file);
  EXPECT_EQ(open_resource(full).error(), OpenError::kChanged);
}

TEST_F(CatalogTest, folders_that_may_not_be_entered_are_faults_and_errors_if_they_are_named) {
  fs::permissions(temporary_.path(), fs::perms::all);
  const fs::path closed = temporary_.path() / "closed", above = temporary_.path() / "above";
  fs::create_directories(above / "sub");
  fs::rename(reel_, closed);
  for (const fs::path& folder : {closed, above}) fs::permissions(folder, fs::perms::none);
  {
    const Unprivileged unprivileged;
    auto catalog = Catalog::load({temporary_.path()});
    ASSERT_TRUE(catalog) << catalog.error().message;
    EXPECT_THAT(catalog->refresh({temporary_.path()}).faults,
                testing::UnorderedElementsAre(closed.string() + ": Permission denied",
                                              above.string() + ": Permission denied"));
    EXPECT_EQ(error_of({closed}), closed.string() + ": Permission denied");
  }
  for (const fs::path& folder : {closed, above}) fs::permissions(folder, fs::perms::owner_all);
}

TEST_F(CatalogTest, opens_another_file_with_the_same_content) {
  const auto catalog = Catalog::load({reel_});
  const Resource& full = *catalog->find("/walk/0.full.prs");
  fs::permissions(full.file, fs::perms::owner_read);
  EXPECT_TRUE(open_resource(full)) << "only its attributes have changed";
  write_file(temporary_.path() / "copy", "the rest");
  fs::rename(temporary_.path() / "copy", full.file);
  EXPECT_TRUE(open_resource(full));
}

TEST_F(CatalogTest, a_file_stays_open_while_somebody_holds_it_unless_it_is_replaced_or_changes) {
  const auto catalog = Catalog::load({reel_});
  const Resource& full = *catalog->find("/walk/0.full.prs");
  const auto first = open_resource(full), second = open_resource(full);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(*first, *second);
  write_file(temporary_.path() / "other", "THE REST");
  fs::rename(temporary_.path() / "other", full.file);
  EXPECT_EQ(open_resource(full).error(), OpenError::kChanged);
  const auto base = open_resource(*catalog->find("/walk/0.base.prs"));
  ASSERT_TRUE(base);
  write_file(reel_ / "0.base.prs", "BASE");
  EXPECT_EQ(open_resource(*catalog->find("/walk/0.base.prs")).error(), OpenError::kChanged);
}

TEST_F(CatalogTest, live_resources_come_and_go_and_never_hide_a_package) {
  auto catalog = Catalog::load({reel_});
  ASSERT_TRUE(catalog) << catalog.error().message;
  const auto live = std::make_shared<LiveResources>();
  catalog->add(live);
  EXPECT_EQ(catalog->find("/live/stage/reel.json"), nullptr);
  live->put("/live/stage/reel.json", text_resource("application/json", kRevalidate, "one"));
  const auto first = catalog->find("/live/stage/reel.json");
  ASSERT_NE(first, nullptr);
  live->put("/live/stage/reel.json", text_resource("application/json", kRevalidate, "two"));
  EXPECT_EQ(catalog->find("/live/stage/reel.json")->text, "two");
  live->put("/walk/reel.json", text_resource("application/json", kRevalidate, "mine"));
  EXPECT_NE(catalog->find("/walk/reel.json")->text, "mine");
  live->remove("/live/stage/reel.json");
  EXPECT_EQ(catalog->find("/live/stage/reel.json"), nullptr);
  EXPECT_EQ(first->text, "one") << "a response in progress keeps the old resource";
}

}  // namespace
}  // namespace pointreel::catalog_test
