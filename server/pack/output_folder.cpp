#include "server/pack/output_folder.h"

#include <string>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <stdio.h>
#include <unistd.h>

namespace pointreel {
namespace fs = std::filesystem;
namespace {

/// Absolute, without "." and ".." and without a slash at the end.
Result<fs::path> normal_form(const fs::path& path) {
  std::error_code error;
  fs::path normal = fs::absolute(path, error).lexically_normal();
  if (error) return fail(fmt::format("{}: {}", path.string(), error.message()));
  if (!normal.has_filename()) normal = normal.parent_path();
  if (!normal.has_filename()) {
    return fail(fmt::format("{}: is no folder that can be made", path.string()));
  }
  return normal;
}

Result<bool> must_replace(const fs::path& final, const OutputFolder::MayReplace& may_replace) {
  std::error_code error;
  const fs::file_status status = fs::symlink_status(final, error);
  if (status.type() == fs::file_type::not_found) return false;
  if (fs::is_directory(status) && fs::is_empty(final, error) && !error) return false;
  if (!may_replace) {
    return fail(fmt::format("{}: exists, give another name or --force", final.string()));
  }
  if (!fs::is_directory(status)) {
    return fail(fmt::format("{}: is not a folder, remove it yourself", final.string()));
  }
  if (const Result<void> judged = may_replace(final); !judged) {
    return fail_at(final.string(), judged.error());
  }
  return true;
}

}  // namespace

Result<OutputFolder> OutputFolder::create(const fs::path& path, const MayReplace& may_replace) {
  const Result<fs::path> final = normal_form(path);
  if (!final) return tl::unexpected(final.error());
  const Result<bool> replace = must_replace(*final, may_replace);
  if (!replace) return tl::unexpected(replace.error());

  std::error_code error;
  for (int attempt = 0; attempt < 1000; ++attempt) {
    fs::path temporary =
        final->parent_path() /
        fmt::format(".{}.partial-{}-{}", final->filename().string(), getpid(), attempt);
    if (fs::create_directory(temporary, error)) {
      return OutputFolder(*final, std::move(temporary), *replace);
    }
    if (error) break;
  }
  return fail(fmt::format("{}: cannot make a folder here: {}", final->parent_path().string(),
                          error ? error.message() : "too many unfinished ones"));
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
      return {};  // what was replaced now has the temporary name, and goes when this does
    }
    const fs::path aside = temporary_.string() + "-old";
    fs::rename(final_, aside, error);
    if (!error) fs::rename(temporary_, final_, error);
    if (error) {
      std::error_code ignored;
      if (fs::exists(aside, ignored)) fs::rename(aside, final_, ignored);
      return fail(fmt::format("{}: {}", final_.string(), error.message()));
    }
    temporary_ = aside;
    return {};
  }
  // This replaces nothing but an empty folder, whoever has made it meanwhile.
  fs::rename(temporary_, final_, error);
  if (error) return fail(fmt::format("{}: {}", final_.string(), error.message()));
  temporary_.clear();
  return {};
}

}  // namespace pointreel
