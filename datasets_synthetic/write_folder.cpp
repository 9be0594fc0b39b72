#include "datasets_synthetic/write_folder.h"

#include <system_error>

#include <fmt/format.h>

#include "common/base/try.h"

namespace pointreel {
namespace {

namespace fs = std::filesystem;

/// Fails if `place` holds anything that this program did not write.
Result<void> check_replaceable(const fs::path& place, const std::string& output,
                               const std::function<bool(std::string_view)>& is_ours) {
  std::error_code error;
  if (!fs::is_directory(place, error)) {
    return fail(ErrorCode::argument, output + ": is not a folder; choose another name");
  }
  for (const auto& entry : fs::directory_iterator(place, error)) {
    const std::string name = entry.path().filename();
    if (!is_ours(name)) {
      return fail(ErrorCode::argument,
                  fmt::format("{}: holds {}, which this program did not write; move it away first",
                              output, name));
    }
  }
  return {};
}

}  // namespace

Result<void> write_folder(const std::string& output, bool force,
                          const std::function<bool(std::string_view name)>& is_ours,
                          const std::function<Result<void>(const fs::path&)>& fill) {
  std::error_code error;
  const fs::path given = fs::absolute(output).lexically_normal();
  const fs::path place = given.has_filename() ? given : given.parent_path();
  const bool replaces =
      fs::exists(place, error) && !(fs::is_directory(place, error) && fs::is_empty(place, error));
  if (replaces && !force) {
    return fail(ErrorCode::argument,
                output + ": already exists; choose another folder or replace it with --force");
  }
  if (replaces) TRY(check_replaceable(place, output, is_ours));
  fs::path beside = place;
  beside += ".partial";
  if (fs::exists(beside, error)) {  // an interrupted run left it behind
    TRY(check_replaceable(beside, beside.string(), is_ours));
    fs::remove_all(beside, error);
  }
  if (!fs::create_directories(beside, error)) {
    return fail(ErrorCode::io,
                fmt::format("{}: cannot make the folder: {}", beside.string(), error.message()));
  }
  Result<void> written = fill(beside);
  if (written) {
    fs::remove_all(place, error);
    if (!error) fs::rename(beside, place, error);
    if (error) written = fail(ErrorCode::io, fmt::format("{}: {}", output, error.message()));
  }
  if (!written) fs::remove_all(beside, error);
  return written;
}

}  // namespace pointreel
