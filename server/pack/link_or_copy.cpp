#include "server/pack/link_or_copy.h"

#include <cstdint>
#include <system_error>

#include <fmt/format.h>

#include "common/file_system/write_file.h"

namespace pointreel {
namespace fs = std::filesystem;

Result<void> link_or_copy(const fs::path& from, const fs::path& to) {
  std::error_code error;
  // A link to a symbolic link would lead elsewhere from another folder.
  if (!fs::is_symlink(from, error)) {
    fs::create_hard_link(from, to, error);
    if (!error) return {};
  }
  fs::copy_file(from, to, error);
  if (!error) return {};
  std::error_code unknown;
  fs::remove(to, unknown);
  // The standard library calls a full disk an input/output error.
  const std::uintmax_t size = fs::file_size(from, unknown);
  if (!unknown && fs::space(to.parent_path(), unknown).available < size && !unknown)
    error = std::make_error_code(std::errc::no_space_on_device);
  return fail(ErrorCode::io, fmt::format("{}: cannot be copied to {}: {}", from.string(),
                                         to.string(), why_not_written(error.value())));
}

}  // namespace pointreel
