#include "datasets_synthetic/write_folder.h"

#include <system_error>

#include <fmt/format.h>

#include "common/base/try.h"
#include "common/file_system/output_folder.h"

namespace pointreel {
namespace fs = std::filesystem;

Result<void> write_folder(const std::string& output, bool force,
                          const std::function<bool(std::string_view name)>& is_ours,
                          const std::function<Result<void>(const fs::path&)>& fill) {
  const auto may_replace = [&is_ours](const fs::path& folder) -> Result<void> {
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
      const std::string name = entry.path().filename().string();
      if (!is_ours(name)) {
        return fail(
            ErrorCode::argument,
            fmt::format("holds {}, which this program did not write; move it away first", name));
      }
    }
    if (error) return fail(ErrorCode::io, error.message());
    return {};
  };
  OutputFolder folder = TRY(OutputFolder::create(
      output, force ? OutputFolder::MayReplace(may_replace) : OutputFolder::MayReplace()));
  TRY(fill(folder.path()));
  return folder.publish();
}

}  // namespace pointreel
