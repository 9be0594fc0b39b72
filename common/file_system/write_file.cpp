#include "common/file_system/write_file.h"

#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <string>
#include <system_error>

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

namespace pointreel {
namespace fs = std::filesystem;
namespace {

ByteView bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

/// Opens a file to be written; errno tells why not. To open a FIFO that nobody reads would block,
/// whatever signal comes.
std::FILE* open_to_write(const fs::path& path) {
  const int file =
      ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NONBLOCK, 0666);
  if (file < 0) return nullptr;
  ::fcntl(file, F_SETFL, ::fcntl(file, F_GETFL) & ~O_NONBLOCK);
  std::FILE* const opened = ::fdopen(file, "wb");
  if (opened == nullptr) ::close(file);
  return opened;
}

/// Writes all bytes; errno tells why not.
bool write_all(const fs::path& path, ByteView bytes) {
  std::FILE* file = open_to_write(path);
  if (file == nullptr) return false;
  // An empty view may have no address, and fwrite must not be given a null pointer.
  const bool written =
      bytes.empty() || std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
  const int error = errno;
  // A full disk may not be reported before this.
  if (std::fclose(file) == 0 && written) return true;
  if (!written) errno = error;
  return false;
}

/// Writes a file that errors call `shown`.
Result<void> write(const fs::path& path, ByteView bytes, const fs::path& shown) {
  if (write_all(path, bytes)) return {};
  const std::string why = why_not_written(errno);
  std::error_code ignored;
  // A device is nobody's to remove.
  if (fs::is_regular_file(path, ignored)) fs::remove(path, ignored);
  return fail(ErrorCode::io, fmt::format("{}: cannot be written: {}", shown.string(), why));
}

}  // namespace

std::string why_not_written(int error) {
  std::string why = std::generic_category().message(error);
  if (error == ENOSPC || error == EDQUOT) return why + "; make room on the disk";
  if (error == ENXIO) return "no program reads it";
  if (error == EMFILE || error == ENFILE) return why + "; raise the limit with ulimit -n";
  return why;
}

Result<void> write_file(const fs::path& path, ByteView bytes) { return write(path, bytes, path); }

Result<void> write_file(const fs::path& path, std::string_view text) {
  return write_file(path, bytes_of(text));
}

Result<void> replace_file(const fs::path& path, ByteView bytes) {
  const fs::path unfinished = fmt::format("{}.{}~", path.string(), ::getpid());
  if (auto written = write(unfinished, bytes, path); !written) return written;
  std::error_code error, ignored;
  fs::rename(unfinished, path, error);
  if (!error) return {};
  fs::remove(unfinished, ignored);
  return fail(ErrorCode::io,
              fmt::format("{}: cannot be replaced: {}", path.string(), error.message()));
}

Result<void> replace_file(const fs::path& path, std::string_view text) {
  return replace_file(path, bytes_of(text));
}

}  // namespace pointreel
