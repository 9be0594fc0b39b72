#include "common/file_system/user_folder.h"

#include <cstdlib>

namespace pointreel {

std::filesystem::path user_folder(const char* variable, const char* below_home) {
  namespace fs = std::filesystem;
  const char *folder = std::getenv(variable), *home = std::getenv("HOME");
  // The specification calls relative paths invalid.
  if (folder != nullptr && fs::path(folder).is_absolute()) return fs::path(folder) / "pointreel";
  if (home == nullptr || !fs::path(home).is_absolute()) return {};
  return fs::path(home) / below_home / "pointreel";
}

}  // namespace pointreel
