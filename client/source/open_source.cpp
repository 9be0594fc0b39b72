#include "client/source/open_source.h"

#include <filesystem>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "client/source/file_source.h"
#include "client/source/folder_source.h"
#include "client/source/http_source.h"
#include "codec/files/cloud_folder.h"
#include "codec/package/http_folder.h"
#include "common/base/try.h"
#include "common/net/url.h"

namespace pointreel {
namespace {

/// Whether it is a folder without points; false if it cannot be listed.
bool has_no_frames(const std::filesystem::path& path) {
  std::error_code error;
  const std::filesystem::directory_iterator entries(path, error);
  return !error && !has_cloud_files(path);
}

/// Packages tell themselves what options tell of files.
void tell_unused(const std::string& where, const SourceOptions& options) {
  std::vector<const char*> unused;
  if (options.fps) unused.push_back("--fps");
  if (!options.topic.empty()) unused.push_back("--topic");
  if (!options.reading.columns.empty()) unused.push_back("--columns");
  if (options.reading.full_color > 0.0) unused.push_back("--color-max");
  if (options.reading.omit_constant) unused.push_back("--omit-constant");
  if (options.placement.scale != 1.0) unused.push_back("--scale");
  if (options.placement.rotation != Placement{}.rotation) unused.push_back("--rotate");
  if (unused.empty() || !options.say) return;
  options.say(fmt::format("warning: {}: is a package, which is shown as it is: {} {} not used",
                          without_secrets(where), fmt::join(unused, ", "),
                          unused.size() == 1 ? "is" : "are"));
}

}  // namespace

Result<std::unique_ptr<Source>> open_source(const std::string& where,
                                            const SourceOptions& options) {
  TRY(check_token(options.token));
  if (is_folder_address(where)) {
    tell_unused(where, options);
    return open_http_source(where, options);
  }
  if (!scheme_of(where).empty()) {
    const Url url = TRY(parse_url(where));
    return fail(ErrorCode::argument,
                fmt::format("{}: {}:// is not supported; give an http://, https:// or s3:// "
                            "address, a package or a folder",
                            where, url.scheme));
  }
  namespace fs = std::filesystem;
  TRY(check_is_there(where));
  std::error_code ignored;
  const fs::path path(where);
  const bool names_manifest = path.filename() == kManifestName;
  if (names_manifest || fs::exists(path / kManifestName, ignored)) {
    tell_unused(where, options);
    if (!names_manifest) return open_file_source(path);
    return open_file_source(path.has_parent_path() ? path.parent_path() : fs::path("."));
  }
  if (has_no_frames(path))
    return fail(ErrorCode::not_found,
                fmt::format("{}: is not a package (it has no {}), and has no point cloud files",
                            where, kManifestName));
  return open_folder_source(path, options);
}

Result<void> check_is_there(const std::string& where) {
  std::error_code ignored;
  if (!scheme_of(where).empty() || std::filesystem::exists(where, ignored)) return {};
  const bool link = std::filesystem::is_symlink(where, ignored);
  return fail(ErrorCode::not_found, where + (link ? ": links to a file or folder that is not there"
                                                  : ": no such file or folder"));
}

}  // namespace pointreel
