#pragma once

#include <filesystem>
#include <string>

#include "codec/live/live.h"

namespace pointreel {

/// The identity of a publisher that keeps its secret in a file of the user's: when it was killed
/// and is started again, it takes its name back at once. There is a file for each address, in
/// pointreel/publishers in $XDG_STATE_HOME or ~/.local/state, while this object lives and after the
/// program was killed. It is locked, so that a second publisher to the same address neither reads
/// it nor keeps its own secret: it never takes the name from one that lives.
class KeptIdentity {
 public:
  /// `url`: where it publishes to. Where no file can be kept, the identity is a new one.
  explicit KeptIdentity(const std::string& url);
  KeptIdentity(const KeptIdentity&) = delete;
  KeptIdentity& operator=(const KeptIdentity&) = delete;
  ~KeptIdentity();

  const LiveIdentity& get() const { return identity_; }

 private:
  LiveIdentity identity_;
  std::filesystem::path path_;  ///< empty unless it is kept
  int file_ = -1;
};

}  // namespace pointreel
