#include "server/service/write_page.h"

#include <fstream>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "codec/package/manifest.h"
#include "common/base/try.h"
#include "common/file_system/write_file.h"
#include "server/service/catalog.h"

namespace pointreel {
namespace {

namespace fs = std::filesystem;

/// Whether there is nothing, or a file that has this text near its beginning, as ours have.
bool is_free_or_has(const fs::path& path, const char* mark) {
  std::error_code error;
  if (!fs::exists(fs::symlink_status(path, error))) return true;
  if (!fs::is_regular_file(fs::symlink_status(path, error))) return false;
  std::ifstream file(path, std::ios::binary);
  std::string text(4096, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  return text.find(mark) != std::string::npos;
}

/// The file, and its compressed forms, as nginx and others take them with gzip_static.
Result<void> write_forms(const fs::path& path, const PageFile& file) {
  TRY(replace_file(path, file.plain));
  if (!file.brotli.empty()) TRY(replace_file(fs::path(path) += ".br", file.brotli));
  if (!file.gzip.empty()) TRY(replace_file(fs::path(path) += ".gz", file.gzip));
  return {};
}

}  // namespace

Result<WrittenPage> write_page(const fs::path& folder, std::span<const PageFile> page, bool force) {
  std::error_code error;
  if (!fs::is_directory(folder, error))
    return fail(ErrorCode::argument, folder.string() + ": is not a folder");
  if (fs::exists(folder / kManifestName, error)) {
    return fail(ErrorCode::argument,
                folder.string() + ": is a package: name the folder that holds the packages");
  }
  if (fs::exists(folder / "page" / kManifestName, error)) {
    return fail(ErrorCode::argument,
                (folder / "page").string() + ": is a package where the page is to lie; rename it");
  }
  if (page.empty())
    return fail(ErrorCode::unsupported, "this Pointreel was built without the page");
  const fs::path index = folder / "index.html";
  if (!force && !is_free_or_has(index, "<title>Pointreel</title>")) {
    return fail(ErrorCode::argument,
                index.string() + ": is another page; use --force to replace it");
  }
  const fs::path reels = folder / "reels.json";
  if (!force && !is_free_or_has(reels, R"("packages")")) {
    return fail(ErrorCode::argument,
                reels.string() + ": is another list; use --force to replace it");
  }
  Catalog catalog;
  std::vector<std::string> faults = catalog.refresh({folder}).faults;
  const std::string list = catalog.list({})->text;
  // The list last, so that a page that is there already finds all that it names.
  const PageFile* start = nullptr;
  for (const PageFile& file : page) {
    if (file.name == "index.html") {
      start = &file;
      continue;
    }
    const fs::path path = folder / "page" / file.name;
    fs::create_directories(path.parent_path(), error);
    if (error) return fail(ErrorCode::io, path.parent_path().string() + ": " + error.message());
    TRY(write_forms(path, file));
  }
  if (start != nullptr) TRY(write_forms(index, *start));
  TRY(replace_file(reels, list));
  return WrittenPage{nlohmann::json::parse(list)["packages"].size(), std::move(faults)};
}

}  // namespace pointreel
