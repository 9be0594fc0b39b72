#pragma once

#include <filesystem>
#include <functional>

#include "pointreel/error.h"

namespace pointreel {

/// A folder that is complete or absent: it is filled beside its final place, in a hidden folder
/// with a name of its own, and renamed when it is complete. Whatever ends its life before that
/// removes it.
class OutputFolder {
 public:
  /// Judges whether a folder that is there already, and not empty, may be replaced; an error says
  /// why not.
  using MayReplace = std::function<Result<void>(const std::filesystem::path&)>;

  /// Refuses a final place that is taken, by anything but an empty folder; unless `may_replace` is
  /// given (--force) and lets it go. The errors begin with the path.
  static Result<OutputFolder> create(const std::filesystem::path& final,
                                     const MayReplace& may_replace = {});

  OutputFolder(OutputFolder&& other) noexcept;
  OutputFolder& operator=(OutputFolder&&) = delete;
  ~OutputFolder();

  /// Where to write.
  const std::filesystem::path& path() const { return temporary_; }

  /// Puts the folder in its place; a folder that it replaces vanishes in the same step where the
  /// file system can swap two names, and just before it elsewhere.
  Result<void> publish();

 private:
  OutputFolder(std::filesystem::path final, std::filesystem::path temporary, bool replace)
      : final_(std::move(final)), temporary_(std::move(temporary)), replace_(replace) {}

  std::filesystem::path final_, temporary_;  // temporary_ is empty once published or moved from
  bool replace_ = false;
};

}  // namespace pointreel
