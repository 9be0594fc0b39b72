#include "datasets_synthetic/write_hard.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <vector>

#include "common/base/try.h"
#include "datasets_synthetic/hard_cases.h"
#include "datasets_synthetic/write_folder.h"

namespace pointreel {
namespace {

namespace fs = std::filesystem;

Result<void> write_text(const fs::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text << std::flush;
  if (!file) return fail(ErrorCode::io, path.string() + ": cannot be written");
  return {};
}

}  // namespace

Result<std::size_t> write_hard(const std::string& output, bool force) {
  const std::vector<HardCase> cases = hard_cases();
  const auto is_ours = [&cases](std::string_view name) {
    return name == kHardManifest || std::any_of(cases.begin(), cases.end(),
                                                [name](const auto& c) { return c.file == name; });
  };
  TRY(write_folder(output, force, is_ours, [&](const fs::path& folder) -> Result<void> {
    TRY(write_text(folder / kHardManifest, hard_manifest(cases)));
    for (const HardCase& c : cases) TRY(write_text(folder / c.file, c.bytes));
    return {};
  }));
  return cases.size();
}

}  // namespace pointreel
