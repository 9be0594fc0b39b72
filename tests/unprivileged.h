#pragma once

#include <unistd.h>

namespace pointreel {

/// While it lives, root has the rights of nobody: root may open every file.
class Unprivileged {
 public:
  Unprivileged() {
    constexpr uid_t kNobody = 65534;
    changed_ = ::geteuid() == 0 && ::seteuid(kNobody) == 0;
  }
  ~Unprivileged() {
    if (changed_) static_cast<void>(::seteuid(0) == 0);
  }
  Unprivileged(const Unprivileged&) = delete;
  Unprivileged& operator=(const Unprivileged&) = delete;

 private:
  bool changed_ = false;
};

}  // namespace pointreel
