#include "client/source/open_source.h"

#include <filesystem>

#include <fmt/format.h>

#include "client/source/file_source.h"
#include "client/source/folder_source.h"
#include "client/source/http_source.h"

namespace pointreel {

Result<std::unique_ptr<Source>> open_source(const std::string& where,
                                            const SourceOptions& options) {
  if (where.starts_with("http://") || where.starts_with("https://"))
    return open_http_source(where, options);
  if (const auto scheme = where.find("://"); scheme != std::string::npos)
    return fail(fmt::format(
        "{}: {}:// is not supported; give an http:// or https:// address, a package or a folder",
        where, where.substr(0, scheme)));
  namespace fs = std::filesystem;
  std::error_code ignored;
  const fs::path path(where);
  if (!fs::exists(path, ignored)) return fail(where + ": no such file or folder");
  if (path.filename() == kManifestName)
    return open_file_source(path.has_parent_path() ? path.parent_path() : fs::path("."));
  if (fs::exists(path / kManifestName, ignored)) return open_file_source(path);
  return open_folder_source(path, options);
}

}  // namespace pointreel
