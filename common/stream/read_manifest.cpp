#include <fstream>
#include <iterator>
#include <system_error>

#include <fmt/format.h>

#include "common/stream/manifest.h"

namespace pointreel {

Result<Manifest> read_manifest(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / kManifestName;
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) {
    return fail(fmt::format("{}: is not a package, there is no {} in it that can be read",
                            folder.string(), kManifestName));
  }
  if (size > kMaxManifestBytes) {
    return fail(fmt::format("{}: is longer than {} bytes", path.string(), kMaxManifestBytes));
  }
  std::ifstream in(path, std::ios::binary);
  std::string text(size, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (!in) return fail(fmt::format("{}: cannot be read", path.string()));
  Result<Manifest> manifest = parse_manifest(text);
  if (!manifest) return fail_at(path.string(), manifest.error());
  return manifest;
}

}  // namespace pointreel
