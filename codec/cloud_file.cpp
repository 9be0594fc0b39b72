#include "codec/cloud_file.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <new>
#include <system_error>

#include <fmt/format.h>

#include "common/base/natural_order.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

namespace fs = std::filesystem;

Result<Bytes> read_bytes(const fs::path& path) {
  std::error_code code;
  const fs::file_status status = fs::status(path, code);
  if (!fs::exists(status)) return fail(ErrorCode::not_found, "no such file");
  if (fs::is_directory(status)) return fail("is a folder, not a point cloud file");
  if (fs::is_character_file(status) || fs::is_block_file(status))
    return fail("is a device, not a point cloud file");
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    return fail(ErrorCode::io, fmt::format("cannot be opened: {}", std::strerror(errno)));
  }
  try {
    Bytes bytes;
    // Read in blocks, because the size that the file system states may be wrong (pipes, /proc).
    constexpr std::size_t kBlock = std::size_t{1} << 20;
    const std::uintmax_t size = fs::is_regular_file(status) ? fs::file_size(path, code) : 0;
    if (!code && size > 0) bytes.reserve(static_cast<std::size_t>(size));
    while (file) {
      const std::size_t at = bytes.size();
      bytes.resize(at + kBlock);
      file.read(reinterpret_cast<char*>(bytes.data() + at), static_cast<std::streamsize>(kBlock));
      bytes.resize(at + static_cast<std::size_t>(file.gcount()));
    }
    if (file.bad()) return fail(ErrorCode::io, "cannot be read to its end");
    return bytes;
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::limit, "is too large for the memory");
  }
}

bool hidden(const fs::path& path) { return path.filename().string().starts_with('.'); }

Result<std::vector<fs::path>> list_folder(const fs::path& folder) {
  std::error_code code;
  std::vector<fs::path> files;
  for (fs::directory_iterator it(folder, code), end; !code && it != end; it.increment(code)) {
    const fs::path& path = it->path();
    std::error_code ignored;  // a dangling link is not a frame
    if (!hidden(path) && is_cloud_file(path) && fs::is_regular_file(path, ignored)) {
      files.push_back(path);
    }
  }
  if (code) {
    return fail(ErrorCode::io,
                fmt::format("{}: cannot be listed: {}", folder.string(), code.message()));
  }
  if (files.empty()) {
    return fail(ErrorCode::not_found,
                fmt::format("{}: has no .ply or .drc files", folder.string()));
  }
  std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
    return natural_less(a.filename().string(), b.filename().string());
  });
  return files;
}

}  // namespace

Result<LoadedCloud> read_cloud_file(const fs::path& path, const DecodeLimits& limits) {
  const Bytes bytes = TRY(at_place(path.string(), read_bytes(path)));
  return at_place(path.string(), read_cloud(bytes, limits));
}

bool is_cloud_file(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension == ".ply" || extension == ".drc";
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
    return fail(ErrorCode::argument, "no input: name a folder or .ply and .drc files");
  }
  return files;
}

}  // namespace pointreel
