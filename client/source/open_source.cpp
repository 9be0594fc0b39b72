#include "client/source/open_source.h"

#include <filesystem>

#include <fmt/format.h>

#include "client/source/file_source.h"
#include "client/source/folder_source.h"
#include "client/source/http_source.h"
#include "codec/files/cloud_file.h"
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

}  // namespace

Result<std::unique_ptr<Source>> open_source(const std::string& where,
                                            const SourceOptions& options) {
  TRY(check_token(options.token));
  if (is_folder_address(where)) return open_http_source(where, options);
  if (!scheme_of(where).empty()) {
    const Url url = TRY(parse_url(where));
    return fail(ErrorCode::argument,
                fmt::format("{}: {}:// is not supported; give an http://, https:// or s3:// "
                            "address, a package or a folder",
                            where, url.scheme));
  }
  namespace fs = std::filesystem;
  std::error_code ignored;
  const fs::path path(where);
  if (!fs::exists(path, ignored)) {
    const bool link = fs::is_symlink(path, ignored);
    return fail(ErrorCode::not_found,
                where + (link ? ": links to a file or folder that is not there"
                              : ": no such file or folder"));
  }
  if (path.filename() == kManifestName)
    return open_file_source(path.has_parent_path() ? path.parent_path() : fs::path("."));
  if (fs::exists(path / kManifestName, ignored)) return open_file_source(path);
  if (has_no_frames(path))
    return fail(ErrorCode::not_found,
                fmt::format("{}: is not a package (it has no {}), and has no point cloud files",
                            where, kManifestName));
  return open_folder_source(path, options);
}

}  // namespace pointreel
