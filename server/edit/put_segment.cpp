#include "server/edit/put_segment.h"

#include <cstddef>
#include <fstream>

#include <fmt/format.h>

#include "codec/package/layer_file_name.h"
#include "common/base/try.h"
#include "common/file_system/write_file.h"
#include "server/pack/link_or_copy.h"
#include "server/store/check_file.h"

namespace pointreel {
namespace fs = std::filesystem;
namespace {

/// Where a file is on this machine, with the size that the manifest says.
Result<fs::path> whole_file(const PackageFiles& from, const PackageFile& file) {
  fs::path path = TRY(from.local(file));
  TRY(at_place(from.shown(file), check_size(path, file)));
  return path;
}

}  // namespace

Result<void> put_file(const PackageFiles& from, const PackageFile& file, const fs::path& folder,
                      const std::string& name) {
  return link_or_copy(TRY(whole_file(from, file)), folder / name);
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

Result<void> put_frames(const PackageFiles& from, const fs::path& folder,
                        const std::vector<std::string>& layer_names, const Segment& whole,
                        std::uint32_t begin, Segment& segment) {
  for (std::size_t i = 0; i < segment.layers.size(); ++i) {
    LayerFile& file = segment.layers[i];
    file.bytes = 0;
    for (const Chunks<std::uint32_t>& sizes : file.frames) file.bytes += total(sizes);
    Bytes bytes(file.bytes);
    const fs::path path = TRY(whole_file(from, whole.layers[i]));
    // The new file has a checksum of its own, which must not make damaged bytes look good.
    TRY(at_place(from.shown(whole.layers[i]), check_checksum(path, whole.layers[i])));
    std::ifstream in(path, std::ios::binary);
    in.seekg(static_cast<std::streamoff>(byte_range(whole.layers[i], begin).offset));
    if (!in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size())))
      return fail(ErrorCode::io, from.shown(whole.layers[i]) + ": cannot be read");
    file.checksum = checksum_of(bytes);
    file.path = layer_file_name(segment.first_frame, layer_names[i], file.checksum);
    TRY(write_file(folder / file.path, bytes));
  }
  segment.sound.reset();
  return {};
}

}  // namespace pointreel
