#include "common/file_system/open_file.h"

#include <cerrno>
#include <cstring>
#include <string>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/base/try.h"

namespace pointreel {
namespace {

tl::unexpected<Error> not_opened() {
  if (errno == ENOENT) return fail(ErrorCode::not_found, "no such file");
  return fail(ErrorCode::io, std::string("cannot be opened: ") + std::strerror(errno));
}

}  // namespace

Result<OpenFile> OpenFile::open(const std::filesystem::path& path) {
  const auto refused = [](const struct stat& status) {
    return fail(S_ISDIR(status.st_mode) ? "is a folder, not a file" : "is not a regular file");
  };
  struct stat status{};
  if (::stat(path.c_str(), &status) != 0) return not_opened();
  if (!S_ISREG(status.st_mode)) return refused(status);
  // It may have become a pipe meanwhile.
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) return not_opened();
  OpenFile file(descriptor, 0);
  if (::fstat(descriptor, &status) != 0) return not_opened();
  if (!S_ISREG(status.st_mode)) return refused(status);
  file.size_ = static_cast<std::uint64_t>(status.st_size);
  return file;
}

OpenFile::~OpenFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Result<std::string> read_text(const std::filesystem::path& path, std::uint64_t most) {
  const OpenFile file = TRY(OpenFile::open(path));
  if (file.size() > most) {
    return fail(ErrorCode::limit, "has " + std::to_string(file.size()) + " bytes; at most " +
                                      std::to_string(most) + " are allowed");
  }
  std::string text(file.size(), '\0');
  std::size_t size = 0;
  while (size < text.size()) {
    const ssize_t got = ::read(file.descriptor(), text.data() + size, text.size() - size);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return fail(ErrorCode::io, std::string("cannot be read: ") + std::strerror(errno));
    if (got == 0) break;
    size += static_cast<std::size_t>(got);
  }
  text.resize(size);
  return text;
}

Result<std::ifstream> open_stream(const std::filesystem::path& path) {
  TRY(OpenFile::open(path));
  std::ifstream stream(path, std::ios::binary);
  if (!stream) return not_opened();
  return stream;
}

}  // namespace pointreel
