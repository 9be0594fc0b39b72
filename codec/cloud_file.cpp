#include "codec/cloud_file.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "codec/formats/byte_source.h"
#include "codec/formats/format_table.h"
#include "common/base/natural_order.h"
#include "common/base/out_of_memory.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

namespace fs = std::filesystem;

bool hidden(const fs::path& path) { return path.filename().string().starts_with('.'); }

Result<std::vector<fs::path>> list_folder(const fs::path& folder) {
  std::error_code code;
  std::vector<fs::path> files, perhaps;
  for (fs::directory_iterator it(folder, code), end; !code && it != end; it.increment(code)) {
    const fs::path& path = it->path();
    const Likely likely = is_cloud_name(path.filename().string());
    std::error_code ignored;  // a dangling link is not a frame
    if (hidden(path) || likely == Likely::no || !fs::is_regular_file(path, ignored)) continue;
    (likely == Likely::yes ? files : perhaps).push_back(path);
  }
  if (code) {
    return fail(ErrorCode::io,
                fmt::format("{}: cannot be listed: {}", folder.string(), code.message()));
  }
  if (files.empty()) files = std::move(perhaps);
  if (files.empty()) {
    return fail(ErrorCode::not_found,
                fmt::format("{}: has no point cloud files: {}", folder.string(), known_formats()));
  }
  std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
    return natural_less(a.filename().string(), b.filename().string());
  });
  return files;
}

/// What suffices to recognise a format.
constexpr std::size_t kBegin = 256;

Result<LoadedCloud> read_source(const ByteSource& source, CloudFormat format,
                                const DecodeLimits& limits) {
  return or_out_of_memory([&]() -> Result<LoadedCloud> {
    std::vector<std::string> unread;
    PointCloud cloud = TRY(read_points(source, format, limits, unread));
    LoadedCloud loaded = usable_cloud(std::move(cloud), format);
    loaded.unread = std::move(unread);
    return loaded;
  });
}

Result<CloudFormat> format_of_file(const ByteSource& source, const fs::path& path) {
  Bytes room;
  return format_of(TRY(source.view(0, kBegin, room)), path.filename().string());
}

}  // namespace

Result<LoadedCloud> read_cloud(ByteView bytes, CloudFormat format, const DecodeLimits& limits) {
  return read_source(ByteSource(bytes), format, limits);
}

Result<LoadedCloud> read_cloud(ByteView bytes, const DecodeLimits& limits) {
  return read_cloud(bytes, format_of(bytes, {}), limits);
}

Result<LoadedCloud> read_cloud_file(const fs::path& path, const DecodeLimits& limits) {
  const ByteSource source = TRY(at_place(path.string(), ByteSource::open(path)));
  const CloudFormat format = TRY(at_place(path.string(), format_of_file(source, path)));
  return at_place(path.string(), read_source(source, format, limits));
}

bool is_cloud_file(const fs::path& path) {
  return is_cloud_name(path.filename().string()) != Likely::no;
}

std::optional<char> up_of_file(const fs::path& path) {
  const auto source = ByteSource::open(path);
  if (!source) return std::nullopt;
  const auto format = format_of_file(*source, path);
  return format ? up_of(*format) : std::nullopt;
}

Result<std::vector<fs::path>> list_cloud_files(const std::vector<fs::path>& inputs) {
  std::vector<fs::path> files;
  for (const fs::path& input : inputs) {
    std::error_code code;
    const fs::file_status status = fs::status(input, code);
    if (!fs::exists(status)) {
      return fail(ErrorCode::not_found, fmt::format("{}: no such file or folder", input.string()));
    }
    if (!fs::is_directory(status)) {
      files.push_back(input);
      continue;
    }
    const std::vector<fs::path> listed = TRY(list_folder(input));
    files.insert(files.end(), listed.begin(), listed.end());
  }
  if (files.empty()) {
    return fail(ErrorCode::argument, "no input: name a folder or files of points");
  }
  return files;
}

}  // namespace pointreel
