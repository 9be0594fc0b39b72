#include "server/edit/put_segment.h"

#include <cstddef>
#include <system_error>

#include <fmt/format.h>

#include "codec/package/layer_file_name.h"
#include "common/base/try.h"
#include "common/base/words.h"
#include "server/pack/link_or_copy.h"

namespace pointreel {
namespace fs = std::filesystem;

Result<void> put_file(const PackageFiles& from, const PackageFile& file, const fs::path& folder,
                      const std::string& name) {
  const fs::path path = TRY(from.local(file));
  std::error_code error;
  const std::uintmax_t size = fs::file_size(path, error);
  if (error) return fail(ErrorCode::io, fmt::format("{}: {}", from.shown(file), error.message()));
  if (size != file.bytes) {
    return fail(fmt::format("{}: has {}, the manifest says {}", from.shown(file),
                            counted(size, "byte"), file.bytes));
  }
  return link_or_copy(path, folder / name);
}

Result<void> put_segment(const PackageFiles& from, const fs::path& folder,
                         const std::vector<std::string>& layer_names, Segment& segment) {
  for (std::size_t i = 0; i < segment.layers.size(); ++i) {
    LayerFile& file = segment.layers[i];
    std::string name = layer_file_name(segment.first_frame, layer_names[i], file.checksum);
    TRY(put_file(from, file, folder, name));
    file.path = std::move(name);
  }
  segment.sound.reset();
  return {};
}

}  // namespace pointreel
