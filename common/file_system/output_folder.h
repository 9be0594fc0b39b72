#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "pointreel/error.h"

namespace pointreel {

/// The message of work on an OutputFolder that was stopped before it was published.
inline constexpr const char* kInterrupted = "interrupted, nothing was written";

/// A folder that is either complete or absent. It is filled in a hidden folder beside its final
/// place, which is renamed when it is complete. If this object ends before that, the hidden folder
/// is removed. What programs that were killed have left there is removed by the next one that
/// writes to the same place.
class OutputFolder {
 public:
  /// Decides whether an existing folder that is not empty may be replaced; the error says why not.
  /// Asked only about folders that hold nothing but regular files.
  using MayReplace = std::function<Result<void>(const std::filesystem::path&)>;

  /// Makes the folders above the final place, if they are missing. An error if something other than
  /// an empty folder is there, unless `may_replace` is given (--force) and allows to replace it.
  /// Errors begin with the path.
  static Result<OutputFolder> create(const std::filesystem::path& final,
                                     const MayReplace& may_replace = {});

  OutputFolder(OutputFolder&& other) noexcept;
  OutputFolder& operator=(OutputFolder&&) = delete;
  ~OutputFolder();

  /// Where to write.
  const std::filesystem::path& path() const { return temporary_; }

  /// Moves the folder to its final place. The folder that it replaces disappears in the same step
  /// if the file system can swap two names, otherwise just before. `may_replace` is asked again,
  /// since the folder may have changed meanwhile.
  Result<void> publish();

 private:
  OutputFolder() = default;
  Result<void> put_in_place_of_another();

  std::filesystem::path final_;
  std::filesystem::path temporary_;             ///< empty once published or moved from
  std::filesystem::path replaced_;              ///< the old folder, once it was replaced
  std::vector<std::filesystem::path> parents_;  ///< folders that were made, outermost first
  MayReplace may_replace_;                      ///< empty if nothing is replaced
  int lock_ = -1;  ///< tells other programs that somebody still writes to the hidden folder
};

}  // namespace pointreel
