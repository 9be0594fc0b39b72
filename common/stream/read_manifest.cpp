#include <fstream>
#include <iterator>
#include <system_error>

#include <fmt/format.h>

#include "common/base/try.h"
#include "common/stream/manifest.h"

namespace pointreel {

Result<Manifest> read_manifest(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / kManifestName;
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) {
    return fail(ErrorCode::not_found,
                fmt::format("{}: is not a package: it has no {}", folder.string(), kManifestName));
  }
  if (size > kMaxManifestBytes) {
    return fail(ErrorCode::limit,
                fmt::format("{}: is longer than {} bytes", path.string(), kMaxManifestBytes));
  }
  std::ifstream in(path, std::ios::binary);
  std::string text(size, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (!in) return fail(ErrorCode::io, fmt::format("{}: cannot be read", path.string()));
  return at_place(path.string(), parse_manifest(text));
}

}  // namespace pointreel
