#include "codec/files/depth_folder.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "codec/files/byte_source.h"
#include "codec/files/depth_capture.h"
#include "codec/files/depth_frame.h"
#include "common/base/concat.h"
#include "common/base/letter_case.h"
#include "common/base/natural_order.h"
#include "common/base/try.h"

namespace pointreel {
namespace fs = std::filesystem;
namespace {

constexpr std::uint64_t kSecond = 1'000'000'000;  // nanoseconds
constexpr std::uint64_t kMostApart = kSecond;
/// Of a file. A picture of 67 million pixels that are not compressed takes less.
constexpr std::uint64_t kMaxPicture = std::uint64_t{1} << 29;

/// In nanoseconds.
std::optional<std::uint64_t> time_in(std::string_view name) {
  const auto number_of = [](std::string_view digits) -> std::optional<std::uint64_t> {
    std::uint64_t number = 0;
    const char* const end = digits.data() + digits.size();
    const auto read = std::from_chars(digits.data(), end, number);
    if (digits.empty() || read.ec != std::errc() || read.ptr != end) return std::nullopt;
    return number;
  };
  const std::size_t point = name.find('.');
  if (point != name.npos) {
    constexpr std::uint64_t kMostSeconds = 9'000'000'000;
    const auto seconds = number_of(name.substr(0, point));
    std::string fraction(name.substr(point + 1));
    if (!seconds || *seconds > kMostSeconds || fraction.empty() || fraction.size() > 9)
      return std::nullopt;
    fraction.resize(9, '0');
    const auto nanoseconds = number_of(fraction);
    if (!nanoseconds) return std::nullopt;
    return *seconds * kSecond + *nanoseconds;
  }
  const auto number = number_of(name);
  if (!number) return std::nullopt;
  if (name.size() == 13) return *number * 1'000'000;
  if (name.size() == 16) return *number * 1'000;
  if (name.size() == 19) return *number;
  return std::nullopt;
}

struct Pictures {
  std::vector<fs::path> files;       ///< in order
  std::vector<std::uint64_t> times;  ///< of all files, in nanoseconds, or empty
};

bool is_picture(const fs::path& file, bool of_depth) {
  std::string ending = file.extension().string();
  for (char& c : ending)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  if (file.filename().string().starts_with('.')) return false;
  return ending == ".png" || (!of_depth && (ending == ".jpg" || ending == ".jpeg"));
}

Result<Pictures> list_pictures(const fs::path& folder, bool of_depth) {
  std::error_code code;
  std::vector<std::pair<fs::path, std::optional<std::uint64_t>>> found;
  bool timed = true;
  for (fs::directory_iterator it(folder, code), end; !code && it != end; it.increment(code)) {
    std::error_code ignored;  // a dangling link is no picture
    if (!is_picture(it->path(), of_depth) || !fs::is_regular_file(it->path(), ignored)) continue;
    found.emplace_back(it->path(), time_in(it->path().stem().string()));
    timed &= found.back().second.has_value();
  }
  if (code)
    return fail(ErrorCode::io, concat(folder.string(), ": cannot be listed: ", code.message()));
  std::sort(found.begin(), found.end(), [&](const auto& a, const auto& b) {
    if (timed && a.second != b.second) return *a.second < *b.second;
    return natural_less(a.first.filename().string(), b.first.filename().string());
  });
  Pictures pictures;
  for (auto& [file, time] : found) {
    pictures.files.push_back(std::move(file));
    if (timed) pictures.times.push_back(*time);
  }
  return pictures;
}

/// The folder in it with the first of these names, in letters of any case; empty if there is none.
fs::path folder_called(std::initializer_list<std::string_view> names, const fs::path& folder) {
  std::error_code ignored;
  for (const std::string_view name : names)
    if (fs::is_directory(folder / name, ignored)) return folder / name;
  for (const std::string_view name : names) {
    std::error_code code;
    for (fs::directory_iterator it(folder, code), end; !code && it != end; it.increment(code)) {
      if (equal_in_any_case(it->path().filename().string(), name) && it->is_directory(ignored))
        return it->path();
    }
  }
  return {};
}

fs::path depth_folder(const fs::path& folder) { return folder_called({"depth"}, folder); }
fs::path color_folder(const fs::path& folder) {
  return folder_called({"color", "rgb", "image", "colour", "colors", "images"}, folder);
}

/// For each picture of depth, the one of colours that is nearest in time, or an empty path if none
/// is within a second.
Result<std::vector<fs::path>> match_by_time(const Pictures& depth, const Pictures& color,
                                            const fs::path& folder,
                                            std::vector<std::string>& warnings) {
  std::vector<fs::path> matches;
  std::size_t missing = 0;
  const std::vector<std::size_t> nearest = nearest_in_time(depth.times, color.times);
  for (std::size_t i = 0; i < nearest.size(); ++i) {
    const std::uint64_t a = depth.times[i], b = color.times[nearest[i]];
    const bool apart = std::max(a, b) - std::min(a, b) > kMostApart;
    missing += apart;
    matches.push_back(apart ? fs::path() : color.files[nearest[i]]);
  }
  if (missing == matches.size()) {
    return fail(
        concat(folder.string(),
               ": has no picture within a second of any depth picture, by the times in their "
               "names; move this folder away to read the depth alone"));
  }
  if (missing > 0) {
    warnings.push_back(
        concat(missing, " of ", matches.size(),
               " depth pictures have no colour picture within a second, and are shown "
               "without colours"));
  }
  return matches;
}

/// For each picture of depth, the one of colours. `warnings`: of those that have none of their own.
Result<std::vector<fs::path>> match(const Pictures& depth, const Pictures& color,
                                    const fs::path& folder, std::vector<std::string>& warnings) {
  if (!depth.times.empty() && !color.times.empty())
    return match_by_time(depth, color, folder, warnings);
  std::map<std::string, fs::path> by_name;
  for (const fs::path& file : color.files) by_name.emplace(file.stem().string(), file);
  std::vector<fs::path> matches;
  std::size_t missing = 0;
  for (const fs::path& file : depth.files) {
    const auto found = by_name.find(file.stem().string());
    missing += found == by_name.end();
    const fs::path& before = matches.empty() ? color.files.front() : matches.back();
    matches.push_back(found == by_name.end() ? before : found->second);
  }
  if (missing < depth.files.size()) {
    if (missing > 0) {
      warnings.push_back(concat(missing, " of ", depth.files.size(),
                                " depth pictures have no colour picture of the same name, and get "
                                "the one before"));
    }
    return matches;
  }
  if (color.files.size() == depth.files.size()) return color.files;
  return fail(concat(folder.string(), ": has ", color.files.size(), " pictures for ",
                     depth.files.size(),
                     " of depth, and neither names nor times in them tell which belong together; "
                     "move this folder away to read the depth alone"));
}

/// Of folders with as many pictures as there are of depth, under names that are not expected.
void warn_of_other_pictures(const fs::path& folder, std::size_t count,
                            std::vector<std::string>& warnings) {
  const fs::path depths = depth_folder(folder);
  std::error_code code;
  for (fs::directory_iterator it(folder, code), end; !code && it != end; it.increment(code)) {
    std::error_code ignored;
    if (!it->is_directory(ignored) || it->path() == depths) continue;
    const Result<Pictures> pictures = list_pictures(it->path(), false);
    if (!pictures || pictures->files.size() < count) continue;
    warnings.push_back(concat("the pictures in ", it->path().filename().string(),
                              " are not read: colours are expected in color, rgb or image"));
  }
}

Result<Bytes> read_picture(const fs::path& file) {
  const ByteSource source = TRY(ByteSource::open(file));
  if (source.size() > kMaxPicture) {
    return fail(ErrorCode::limit, concat("has ", source.size(), " bytes, more than ", kMaxPicture));
  }
  Bytes room;
  const ByteView bytes = TRY(source.all(room));
  if (bytes.data() != room.data()) return Bytes(bytes.begin(), bytes.end());
  room.resize(bytes.size());
  return room;
}

class DepthFolder : public Recording {
 public:
  DepthFolder(std::string intrinsics, Pictures depth, std::vector<fs::path> colors,
              std::vector<std::string> warnings)
      : intrinsics_(std::move(intrinsics)),
        depth_(std::move(depth)),
        colors_(std::move(colors)),
        warnings_(std::move(warnings)) {}

  CloudFormat format() const override { return CloudFormat::depth_frame; }
  std::size_t size() const override { return depth_.files.size(); }
  std::optional<std::uint64_t> time_ns(std::size_t frame) const override {
    if (depth_.times.empty()) return std::nullopt;
    return depth_.times[frame];
  }
  RecordingLoss loss() const override { return {warnings_, 0}; }
  std::vector<std::string> guesses() const override { return guesses_of(intrinsics_); }
  std::string name(std::size_t frame) const override {
    return concat("depth/", depth_.files[frame].filename().string());
  }
  Result<Bytes> read(std::size_t frame) const override {
    const Bytes depth = TRY(read_picture(depth_.files[frame]));
    Bytes color;
    if (!colors_.empty() && !colors_[frame].empty()) {
      const fs::path& file = colors_[frame];
      const std::string name = (file.parent_path().filename() / file.filename()).string();
      color = TRY(at_place(name, read_picture(colors_[frame])));
      if (color.empty()) return fail(name + ": is empty");
    }
    return depth_frame(intrinsics_, depth, color);
  }

 private:
  const std::string intrinsics_;
  const Pictures depth_;
  /// Of each frame, an empty path for those without; or none at all.
  const std::vector<fs::path> colors_;
  const std::vector<std::string> warnings_;
};

}  // namespace

bool is_depth_folder(const fs::path& folder) {
  std::error_code code;
  for (fs::directory_iterator it(depth_folder(folder), code), end; !code && it != end;
       it.increment(code))
    if (is_picture(it->path(), true)) return true;
  return false;
}

fs::path capture_of_pictures(const fs::path& folder) {
  fs::path pictures = folder.lexically_normal();
  if (!pictures.has_filename()) pictures = pictures.parent_path();
  const fs::path capture = pictures.has_parent_path() ? pictures.parent_path() : fs::path(".");
  std::error_code ignored;
  const bool is_its_folder =
      is_depth_folder(capture) && fs::equivalent(depth_folder(capture), pictures, ignored);
  return is_its_folder ? capture : fs::path();
}

std::vector<fs::path> picture_folders(const fs::path& folder) {
  std::vector<fs::path> folders = {depth_folder(folder)};
  if (const fs::path colors = color_folder(folder); !colors.empty()) folders.push_back(colors);
  return folders;
}

Result<std::shared_ptr<const Recording>> open_depth_folder(const fs::path& folder) {
  const fs::path depths = depth_folder(folder);
  Pictures depth = TRY(list_pictures(depths, true));
  if (depth.files.empty())
    return fail(ErrorCode::not_found, concat(depths.string(), ": has no PNG files"));
  std::string intrinsics = TRY(find_intrinsics(intrinsics_in(folder)));
  std::vector<fs::path> colors;
  std::vector<std::string> warnings;
  if (const fs::path from = color_folder(folder); !from.empty()) {
    const Pictures color = TRY(list_pictures(from, false));
    if (!color.files.empty()) {
      colors = TRY(match(depth, color, from, warnings));
    } else {
      warnings.push_back(from.filename().string() + " has no pictures of colours");
    }
  }
  if (colors.empty()) warn_of_other_pictures(folder, depth.files.size(), warnings);
  return std::make_shared<const DepthFolder>(std::move(intrinsics), std::move(depth),
                                             std::move(colors), std::move(warnings));
}

}  // namespace pointreel
