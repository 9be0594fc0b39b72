#include "server/pack/output_folder.h"

#include <string>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <stdio.h>
#include <unistd.h>

#include "common/base/try.h"

namespace pointreel {
namespace fs = std::filesystem;
namespace {

/// The path, absolute, without "." and ".." and without a slash at its end.
Result<fs::path> normal_form(const fs::path& path) {
  std::error_code error;
  fs::path normal = fs::absolute(path, error).lexically_normal();
  if (error) return fail(ErrorCode::io, fmt::format("{}: {}", path.string(), error.message()));
  if (!normal.has_filename()) normal = normal.parent_path();
  if (!normal.has_filename()) {
    return fail(ErrorCode::argument,
                fmt::format("{}: cannot be the output folder; name another one", path.string()));
  }
  return normal;
}

Result<bool> must_replace(const fs::path& final, const OutputFolder::MayReplace& may_replace) {
  std::error_code error;
  const fs::file_status status = fs::symlink_status(final, error);
  if (status.type() == fs::file_type::not_found) return false;
  if (fs::is_directory(status) && fs::is_empty(final, error) && !error) return false;
  if (!may_replace) {
    return fail(ErrorCode::argument,
                fmt::format("{}: exists; name another folder or use --force", final.string()));
  }
  if (!fs::is_directory(status)) {
    return fail(ErrorCode::argument,
                fmt::format("{}: is not a folder; remove it first", final.string()));
  }
  if (const Result<void> judged = may_replace(final); !judged) {
    return fail_at(final.string(), judged.error());
  }
  return true;
}

}  // namespace

Result<OutputFolder> OutputFolder::create(const fs::path& path, const MayReplace& may_replace) {
  const fs::path final = TRY(normal_form(path));
  const bool replace = TRY(must_replace(final, may_replace));
  std::error_code error;
  for (int attempt = 0; attempt < 1000; ++attempt) {
    fs::path temporary =
        final.parent_path() /
        fmt::format(".{}.partial-{}-{}", final.filename().string(), getpid(), attempt);
    if (fs::create_directory(temporary, error)) {
      return OutputFolder(final, std::move(temporary), replace);
    }
    if (error) break;
  }
  return fail(ErrorCode::io,
              fmt::format("{}: cannot create a folder here: {}", final.parent_path().string(),
                          error ? error.message() : "there are too many unfinished ones"));
}

OutputFolder::OutputFolder(OutputFolder&& other) noexcept
    : final_(std::move(other.final_)),
      temporary_(std::exchange(other.temporary_, {})),
      replace_(other.replace_) {}

OutputFolder::~OutputFolder() {
  std::error_code ignored;
  if (!temporary_.empty()) fs::remove_all(temporary_, ignored);
}

Result<void> OutputFolder::publish() {
  std::error_code error;
  if (replace_) {
    if (renameat2(AT_FDCWD, temporary_.c_str(), AT_FDCWD, final_.c_str(), RENAME_EXCHANGE) == 0) {
      return {};  // the old folder now has the temporary name, and is removed by the destructor
    }
    const fs::path aside = temporary_.string() + "-old";
    fs::rename(final_, aside, error);
    if (!error) fs::rename(temporary_, final_, error);
    if (error) {
      std::error_code ignored;
      if (fs::exists(aside, ignored)) fs::rename(aside, final_, ignored);
      return fail(ErrorCode::io, fmt::format("{}: {}", final_.string(), error.message()));
    }
    temporary_ = aside;
    return {};
  }
  // This replaces nothing but an empty folder, even if someone has put something there meanwhile.
  fs::rename(temporary_, final_, error);
  if (error) return fail(ErrorCode::io, fmt::format("{}: {}", final_.string(), error.message()));
  temporary_.clear();
  return {};
}

}  // namespace pointreel
