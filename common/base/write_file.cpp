#include "common/base/write_file.h"

#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>

#include <fmt/format.h>

namespace pointreel {

Result<void> write_file(const std::filesystem::path& path, ByteView bytes) {
  const auto failed = [&path] {
    return fail(ErrorCode::io,
                fmt::format("{}: cannot be written: {}", path.string(), std::strerror(errno)));
  };
  std::FILE* file = std::fopen(path.c_str(), "wb");
  if (file == nullptr) return failed();
  // An empty view may have no address, and fwrite must not be given a null pointer.
  const bool written =
      bytes.empty() || std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
  if (!written) {
    const auto error = failed();
    std::fclose(file);
    return error;
  }
  // A full disk may not be reported before this.
  if (std::fclose(file) != 0) return failed();
  return {};
}

Result<void> write_file(const std::filesystem::path& path, std::string_view text) {
  return write_file(path,
                    ByteView(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
}

}  // namespace pointreel
