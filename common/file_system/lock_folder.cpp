#include "common/file_system/lock_folder.h"

#include <cerrno>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

namespace pointreel {

int lock_folder(const std::filesystem::path& folder, int wait) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  if (descriptor < 0) return -1;
  struct stat locked{}, present{};
  int why = 0;
  if (::flock(descriptor, LOCK_EX | wait) != 0 || ::fstat(descriptor, &locked) != 0 ||
      ::lstat(folder.c_str(), &present) != 0) {
    why = errno;
  } else if (locked.st_ino == present.st_ino && locked.st_dev == present.st_dev) {
    return descriptor;
  } else {
    why = ESTALE;
  }
  ::close(descriptor);
  errno = why;
  return -1;
}

}  // namespace pointreel
