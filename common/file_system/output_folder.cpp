#include "common/file_system/output_folder.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <string>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <stdio.h>
#include <sys/file.h>
#include <unistd.h>

#include "common/base/try.h"
#include "common/file_system/lock_folder.h"

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

/// Whether a folder may be replaced. Only regular files can be known by their names: a folder or a
/// link of such a name is somebody else's.
Result<void> judge(const fs::path& folder, const OutputFolder::MayReplace& may_replace) {
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (entry.symlink_status(error).type() != fs::file_type::regular) {
      return fail(ErrorCode::argument,
                  fmt::format("holds {}, which is not a plain file; remove it first",
                              entry.path().filename().string()));
    }
  }
  if (error) return fail(ErrorCode::io, error.message());
  return may_replace(folder);
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
  if (const Result<void> judged = judge(final, may_replace); !judged) {
    return fail_at(final.string(), judged.error());
  }
  return true;
}

/// Makes the folders above `path` that are missing. Returns them, outermost first.
Result<std::vector<fs::path>> make_parents(const fs::path& path) {
  std::vector<fs::path> made;
  std::error_code error;
  fs::path parent = path.parent_path();
  while (!fs::exists(parent, error) && !error && parent.has_relative_path()) {
    made.push_back(parent);
    parent = parent.parent_path();
  }
  std::reverse(made.begin(), made.end());
  fs::create_directories(path.parent_path(), error);
  if (error) {
    return fail(ErrorCode::io, fmt::format("{}: cannot be created: {}", path.parent_path().string(),
                                           error.message()));
  }
  return made;
}

/// Removes a folder of files. Folders in it, which no program of ours makes, stay, and so it does.
void remove_files(const fs::path& folder) {
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    if (!fs::is_directory(entry.symlink_status(ignored))) fs::remove(entry.path(), ignored);
  }
  ::rmdir(folder.c_str());
}

std::string hidden_prefix(const fs::path& final) {
  return fmt::format(".{}.partial-", final.filename().string());
}

/// Different in each call, so that threads that write to one place never make the same name: what
/// one of them has removed as abandoned must not come back as the folder of another.
std::uint64_t next_number() {
  static std::atomic<std::uint64_t> number{0};
  return number++;
}

/// Removes the hidden folders for this place that no program writes to any more.
void remove_abandoned(const fs::path& final) {
  const std::string prefix = hidden_prefix(final);
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(final.parent_path(), ignored)) {
    if (!entry.path().filename().string().starts_with(prefix)) continue;
    const int lock = lock_folder(entry.path(), LOCK_NB);
    if (lock < 0) continue;
    remove_files(entry.path());
    ::close(lock);
  }
}

}  // namespace

Result<OutputFolder> OutputFolder::create(const fs::path& path, const MayReplace& may_replace) {
  OutputFolder folder;
  folder.final_ = TRY(normal_form(path));
  if (TRY(must_replace(folder.final_, may_replace))) folder.may_replace_ = may_replace;
  folder.parents_ = TRY(make_parents(folder.final_));
  remove_abandoned(folder.final_);
  const fs::path parent = folder.final_.parent_path();
  std::error_code error;
  for (int attempt = 0; attempt < 1000; ++attempt) {
    fs::path temporary =
        parent / fmt::format("{}{}-{}", hidden_prefix(folder.final_), getpid(), next_number());
    if (fs::create_directory(temporary, error)) {
      // Another program may take it for abandoned before it is locked, and remove it.
      folder.lock_ = lock_folder(temporary, 0);
      if (folder.lock_ < 0 && (errno == ENOENT || errno == ESTALE)) continue;
      folder.temporary_ = std::move(temporary);
      return folder;
    }
    if (error) break;
  }
  return fail(ErrorCode::io,
              fmt::format("{}: cannot create a folder here: {}", parent.string(),
                          error ? error.message() : "there are too many unfinished ones"));
}

OutputFolder::OutputFolder(OutputFolder&& other) noexcept
    : final_(std::move(other.final_)),
      temporary_(std::exchange(other.temporary_, {})),
      replaced_(std::exchange(other.replaced_, {})),
      parents_(std::exchange(other.parents_, {})),
      may_replace_(std::move(other.may_replace_)),
      lock_(std::exchange(other.lock_, -1)) {}

OutputFolder::~OutputFolder() {
  std::error_code ignored;
  if (!temporary_.empty()) fs::remove_all(temporary_, ignored);
  if (!replaced_.empty()) remove_files(replaced_);
  for (auto made = parents_.rbegin(); made != parents_.rend(); ++made) ::rmdir(made->c_str());
  if (lock_ >= 0) ::close(lock_);
}

Result<void> OutputFolder::publish() {
  if (may_replace_) {
    TRY(put_in_place_of_another());
  } else {
    // This replaces nothing but an empty folder, even if someone has put something there meanwhile.
    std::error_code error;
    fs::rename(temporary_, final_, error);
    if (error)
      return fail(ErrorCode::io, fmt::format("{}: {}", final_.string(),
                                             error == std::errc::directory_not_empty
                                                 ? "another program has written it meanwhile"
                                                 : error.message()));
    temporary_.clear();
  }
  parents_.clear();
  return {};
}

Result<void> OutputFolder::put_in_place_of_another() {
  // A recording that still grows is locked, and so is a folder that was published just now.
  errno = 0;
  const int old_lock = lock_folder(final_, LOCK_NB);
  if (old_lock < 0 && errno == EWOULDBLOCK) {
    return fail(ErrorCode::io, fmt::format("{}: another program is writing to it; try again later",
                                           final_.string()));
  }
  const fs::path aside =
      final_.parent_path() /
      fmt::format(".{}.replaced-{}-{}", final_.filename().string(), getpid(), next_number());
  Result<void> done;
  const auto swap = [&] {
    return renameat2(AT_FDCWD, temporary_.c_str(), AT_FDCWD, final_.c_str(), RENAME_EXCHANGE) == 0;
  };
  if (swap()) {
    // Asked again where nobody else can change it any more.
    done = judge(temporary_, may_replace_);
    if (done || !swap()) replaced_ = std::exchange(temporary_, {});
    if (!done) replaced_.clear();
  } else if (::rename(final_.c_str(), aside.c_str()) == 0) {
    done = judge(aside, may_replace_);
    if (done && ::rename(temporary_.c_str(), final_.c_str()) != 0) {
      done = fail(ErrorCode::io, std::generic_category().message(errno));
    }
    if (done) {
      temporary_.clear();
      replaced_ = aside;
    } else {
      ::rename(aside.c_str(), final_.c_str());
    }
  } else {
    done = fail(ErrorCode::io, std::generic_category().message(errno));
  }
  if (old_lock >= 0) ::close(old_lock);
  if (!done) return fail_at(final_.string(), done.error());
  return {};
}

}  // namespace pointreel
