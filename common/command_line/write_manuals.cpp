#include "common/command_line/write_manuals.h"

#include <string>
#include <system_error>

#include <fmt/format.h>

#include "common/base/try.h"
#include "common/command_line/completion.h"
#include "common/command_line/manual.h"
#include "common/file_system/write_file.h"

namespace pointreel::cli {
namespace {

namespace fs = std::filesystem;

Result<void> write(const fs::path& file, const std::string& text) {
  std::error_code error;
  fs::create_directories(file.parent_path(), error);
  if (error) {
    return fail(ErrorCode::io, fmt::format("{}: cannot be made: {}", file.parent_path().string(),
                                           error.message()));
  }
  return write_file(file, text);
}

}  // namespace

Result<void> write_manuals(const std::vector<CommandEntry>& commands, const fs::path& folder) {
  for (const CommandEntry& command : commands)
    TRY(write(folder / "man/man1" / (manual_name(command) + ".1"), manual_page(command)));
  const std::string name = commands.front().path.front();
  TRY(write(folder / "bash-completion/completions" / name, bash_completion(commands)));
  TRY(write(folder / "zsh/vendor-completions" / ("_" + name), zsh_completion(commands)));
  TRY(write(folder / "fish/vendor_completions.d" / (name + ".fish"), fish_completion(commands)));
  return {};
}

}  // namespace pointreel::cli
