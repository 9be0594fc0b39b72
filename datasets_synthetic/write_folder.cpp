#include "datasets_synthetic/write_folder.h"

#include <system_error>

#include <fmt/format.h>

namespace pointreel {
namespace {

namespace fs = std::filesystem;

Result<void> may_replace(const fs::path& place, const std::string& output,
                         const std::function<bool(std::string_view)>& is_ours) {
  std::error_code error;
  if (!fs::is_directory(place, error)) return fail(fmt::format("{}: is not a folder", output));
  for (const auto& entry : fs::directory_iterator(place, error)) {
    const std::string name = entry.path().filename();
    if (!is_ours(name)) {
      return fail(
          fmt::format("{}: holds {}, which is none of the files to be written; move it "
                      "away first",
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
    return fail(
        fmt::format("{}: exists; choose another folder or replace it with --force", output));
  }
  if (replaces) {  // never sweep away what this program did not write
    const Result<void> may = may_replace(place, output, is_ours);
    if (!may) return may;
  }
  fs::path beside = place;
  beside += ".partial";
  if (fs::exists(beside, error)) {  // what an interrupted run left behind
    const Result<void> may = may_replace(beside, beside.string(), is_ours);
    if (!may) return may;
    fs::remove_all(beside, error);
  }
  if (!fs::create_directories(beside, error)) {
    return fail(fmt::format("{}: cannot make the folder: {}", beside.string(), error.message()));
  }
  Result<void> written = fill(beside);
  if (written) {
    fs::remove_all(place, error);
    if (!error) fs::rename(beside, place, error);
    if (error) written = fail(fmt::format("{}: {}", output, error.message()));
  }
  if (!written) fs::remove_all(beside, error);
  return written;
}

}  // namespace pointreel
