#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>

#include "pointreel/error.h"

namespace pointreel {

/// A folder for files that are needed for a while. It goes with its owner.
class ScratchFolder {
 public:
  ScratchFolder() = default;
  ~ScratchFolder() {
    std::error_code ignored;
    if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  /// The folder, which is made when it is first asked for, in $TMPDIR or /tmp.
  /// Errors: `io`; the message is the folder's path and `failure`.
  Result<std::filesystem::path> path(std::string_view failure) {
    if (!path_.empty()) return path_;
    const char* given = std::getenv("TMPDIR");
    const std::filesystem::path folder = given == nullptr || *given == '\0' ? "/tmp" : given;
    std::string name = (folder / "pointreel-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) return fail(ErrorCode::io, name.append(failure));
    return path_ = name;
  }

 private:
  std::filesystem::path path_;
};

}  // namespace pointreel
