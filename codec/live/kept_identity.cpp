#include "codec/live/kept_identity.h"

#include <filesystem>
#include <string_view>
#include <system_error>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include "common/file_system/user_folder.h"

namespace pointreel {
namespace {

namespace fs = std::filesystem;

std::string read_text(int file) {
  char text[64];
  const ssize_t size = ::pread(file, text, sizeof(text), 0);
  return {text, static_cast<std::size_t>(size > 0 ? size : 0)};
}

}  // namespace

KeptIdentity::KeptIdentity(const std::string& url) {
  const fs::path state = user_folder("XDG_STATE_HOME", ".local/state");
  if (state.empty()) return;
  const fs::path folder = state / "publishers";
  std::error_code error;
  fs::create_directories(folder, error);
  path_ = folder / fmt::format("{:016x}", XXH3_64bits(url.data(), url.size()));
  constexpr mode_t kForUserOnly = 0600;
  file_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, kForUserOnly);
  struct stat status{};
  if (file_ < 0 || ::fstat(file_, &status) != 0 || !S_ISREG(status.st_mode) ||
      status.st_uid != ::geteuid() || ::fchmod(file_, kForUserOnly) != 0 ||
      ::flock(file_, LOCK_EX | LOCK_NB) != 0) {
    path_.clear();
    return;
  }
  identity_.earlier = parse_secret(read_text(file_));
  const std::string text = secret_text(identity_.secret);
  // Where it cannot be kept, as on a full disk, the next run waits until the name is free.
  if (::ftruncate(file_, 0) != 0 ||
      ::pwrite(file_, text.data(), text.size(), 0) != static_cast<ssize_t>(text.size()))
    ::unlink(path_.c_str());
}

KeptIdentity::~KeptIdentity() {
  // A publisher that is not killed gives its name back itself.
  if (!path_.empty()) ::unlink(path_.c_str());
  if (file_ >= 0) ::close(file_);
}

}  // namespace pointreel
