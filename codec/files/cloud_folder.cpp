#include "codec/files/cloud_folder.h"

#include <algorithm>
#include <array>
#include <map>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "codec/files/depth_folder.h"
#include "codec/files/format_table.h"
#include "common/base/letter_case.h"
#include "common/base/natural_order.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

namespace fs = std::filesystem;

bool hidden(const fs::path& path) { return path.filename().string().starts_with('.'); }

/// Keeps only the files of the commonest format: a file of another one is a model or a copy, not a
/// frame. A recording is more than any number of files of one cloud. Fails if two formats have
/// equally many files.
Result<void> keep_commonest_format(const fs::path& folder, std::vector<fs::path>& files,
                                   std::vector<std::string>* warnings) {
  std::map<CloudFormat, std::vector<fs::path>> by_format;
  for (const fs::path& file : files)
    by_format[format_of({}, file.filename().string())].push_back(file);
  if (by_format.size() < 2) return {};
  const auto weight = [](const auto& kind) {
    return std::pair(kind.first == CloudFormat::mcap, kind.second.size());
  };
  const auto most =
      std::max_element(by_format.begin(), by_format.end(),
                       [&](const auto& a, const auto& b) { return weight(a) < weight(b); });
  const std::string kept = most->second.front().filename().string();
  for (const auto& other : by_format) {
    if (&other == &*most) continue;
    const std::string first = other.second.front().filename().string();
    if (weight(other) == weight(*most)) {
      return fail(
          ErrorCode::argument,
          fmt::format("{0}: has as many files like {1} as like {2}; name those that are the "
                      "frames, such as {0}/*{3}",
                      folder.string(), kept, first, most->second.front().extension().string()));
    }
    if (warnings == nullptr) continue;
    const std::size_t count = other.second.size();
    warnings->push_back(
        count == 1 ? fmt::format("{}: is left out, because the frames here are files such as {}",
                                 other.second.front().string(), kept)
                   : fmt::format("{}: {} files such as {} are left out, because the frames here "
                                 "are files such as {}",
                                 folder.string(), count, first, kept));
  }
  files = std::move(most->second);
  return {};
}

/// Whether it is text that data sets keep beside their scans, by its name.
bool is_about_scans(const fs::path& file) {
  constexpr std::array<std::string_view, 14> kStems{
      "notes",    "calib",      "calibration", "groundtruth", "info",  "intrinsics", "license",
      "metadata", "trajectory", "poses",       "readme",      "times", "timestamps", "extrinsics"};
  const std::string ending = in_small_letters(file.extension().string());
  const std::string stem = in_small_letters(file.stem().string());
  return (ending == ".txt" || ending == ".csv") && std::ranges::find(kStems, stem) != kStems.end();
}

/// "; its folder velodyne has some" if there are such.
std::string hint_at_folders(const fs::path& folder) {
  std::error_code code;
  for (fs::directory_iterator it(folder, code), end; !code && it != end; it.increment(code)) {
    std::error_code ignored;
    if (it->is_directory(ignored) && !hidden(it->path()) && has_cloud_files(it->path()))
      return fmt::format("; its folder {} has some", it->path().filename().string());
  }
  return {};
}

Result<std::vector<fs::path>> list_folder(const fs::path& folder,
                                          std::vector<std::string>* warnings) {
  std::error_code code;
  std::vector<fs::path> files, perhaps, about;
  for (fs::directory_iterator it(folder, code), end; !code && it != end; it.increment(code)) {
    const fs::path& path = it->path();
    const Likely likely = is_cloud_name(path.filename().string());
    if (hidden(path) || likely == Likely::no) continue;
    if (is_about_scans(path)) {
      about.push_back(path);
      continue;
    }
    std::error_code error;  // also of a dangling link
    if (fs::is_regular_file(path, error)) {
      (likely == Likely::yes ? files : perhaps).push_back(path);
    } else if (likely == Likely::yes && warnings != nullptr) {
      warnings->push_back(path.string() + ": is left out, because it is not a regular file");
    }
    // Whoever may list a folder need not be allowed to open what is in it.
    if (error == std::errc::permission_denied) {
      code = error;
      break;
    }
  }
  if (code) {
    return fail(ErrorCode::io,
                fmt::format("{}: cannot be read: {}", folder.string(), code.message()));
  }
  const bool has_depth = is_depth_folder(folder);
  if (files.empty() && has_depth) return std::vector<fs::path>{folder};
  if (files.empty()) files = std::move(perhaps);
  if (const fs::path capture = capture_of_pictures(folder); files.empty() && !capture.empty())
    return std::vector<fs::path>{capture};
  if (files.empty()) {
    return fail(ErrorCode::not_found,
                fmt::format("{}: has no point cloud files; known are {}{}", folder.string(),
                            known_formats(), hint_at_folders(folder)));
  }
  const bool are_text = format_of({}, files.front().filename().string()) == CloudFormat::text;
  for (const fs::path& path : about) {
    if (are_text && warnings != nullptr)
      warnings->push_back(path.string() +
                          ": is left out: files of this name usually hold no points");
  }
  std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
    return natural_less(a.filename().string(), b.filename().string());
  });
  TRY(keep_commonest_format(folder, files, warnings));
  if (has_depth && warnings != nullptr) {
    warnings->push_back(fmt::format(
        "{0}: its depth pictures are left out, because the frames here are files such as {1}; name "
        "{0}/depth to read them instead",
        folder.string(), files.front().filename().string()));
  }
  return files;
}

}  // namespace

bool is_cloud_file(const fs::path& path) {
  return is_cloud_name(path.filename().string()) != Likely::no;
}

bool has_cloud_files(const fs::path& folder) {
  std::error_code error;
  const fs::directory_iterator entries(folder, error);
  if (error) return false;
  return std::any_of(begin(entries), end(entries),
                     [](const auto& entry) {
                       return is_cloud_file(entry.path()) && !is_about_scans(entry.path());
                     }) ||
         is_depth_folder(folder) || !capture_of_pictures(folder).empty();
}

Result<std::vector<fs::path>> list_cloud_files(const std::vector<fs::path>& inputs,
                                               std::vector<std::string>* warnings) {
  std::vector<fs::path> files;
  for (const fs::path& input : inputs) {
    std::error_code code;
    const fs::file_status status = fs::status(input, code);
    if (code == std::errc::permission_denied)
      return fail(ErrorCode::io, fmt::format("{}: {}", input.string(), code.message()));
    if (!fs::exists(status)) {
      return fail(ErrorCode::not_found, fmt::format("{}: no such file or folder", input.string()));
    }
    if (!fs::is_directory(status)) {
      files.push_back(input);
      continue;
    }
    const std::vector<fs::path> listed = TRY(list_folder(input, warnings));
    files.insert(files.end(), listed.begin(), listed.end());
  }
  if (files.empty()) {
    return fail(ErrorCode::argument, "no input: name a folder or files of points");
  }
  return files;
}

}  // namespace pointreel
