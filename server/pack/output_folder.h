#pragma once

#include <filesystem>
#include <functional>

#include "pointreel/error.h"

namespace pointreel {

/// The message of work on an OutputFolder that was stopped before it was published.
inline constexpr const char* kInterrupted = "interrupted, nothing was written";

/// A folder that is either complete or absent. It is filled in a hidden folder beside its final
/// place, which is renamed when it is complete. If this object ends before that, the hidden folder
/// is removed.
class OutputFolder {
 public:
  /// Decides whether an existing folder that is not empty may be replaced; the error says why not.
  using MayReplace = std::function<Result<void>(const std::filesystem::path&)>;

  /// An error if something other than an empty folder is in the final place, unless `may_replace`
  /// is given (--force) and allows to replace it. Errors begin with the path.
  static Result<OutputFolder> create(const std::filesystem::path& final,
                                     const MayReplace& may_replace = {});

  OutputFolder(OutputFolder&& other) noexcept;
  OutputFolder& operator=(OutputFolder&&) = delete;
  ~OutputFolder();

  /// Where to write.
  const std::filesystem::path& path() const { return temporary_; }

  /// Moves the folder to its final place. The folder that it replaces disappears in the same step
  /// if the file system can swap two names, otherwise just before.
  Result<void> publish();

 private:
  OutputFolder(std::filesystem::path final, std::filesystem::path temporary, bool replace)
      : final_(std::move(final)), temporary_(std::move(temporary)), replace_(replace) {}

  std::filesystem::path final_, temporary_;  // temporary_ is empty once published or moved from
  bool replace_ = false;
};

}  // namespace pointreel
