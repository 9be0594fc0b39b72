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
  int why = 0;
  errno = 0;
  if (::flock(descriptor, LOCK_EX | wait) != 0) {
    why = errno;
  } else if (is_still(descriptor, folder)) {
    return descriptor;
  } else {
    why = errno != 0 ? errno : ESTALE;
  }
  ::close(descriptor);
  errno = why;
  return -1;
}

bool is_still(int descriptor, const std::filesystem::path& folder) {
  struct stat opened{}, present{};
  return ::fstat(descriptor, &opened) == 0 && ::lstat(folder.c_str(), &present) == 0 &&
         opened.st_ino == present.st_ino && opened.st_dev == present.st_dev;
}

}  // namespace pointreel
