#include "client/source/fetched.h"

#include <algorithm>

#include "common/base/concat.h"

namespace pointreel {

Chunks<ByteView> FetchedLayer::view() const {
  const ByteView all = bytes.view();
  return {all.subspan(0, sizes.geometry), all.subspan(sizes.geometry, sizes.colors),
          all.subspan(std::size_t{sizes.geometry} + sizes.colors, sizes.normals)};
}

Result<std::shared_ptr<const ContextTables>> read_tables(const PackageFile& file, ByteView bytes) {
  if (bytes.size() != file.bytes || checksum_of(bytes) != file.checksum) {
    return fail("is not the file that the manifest names; the package is damaged");
  }
  return read_table_file(bytes);
}

std::uint64_t FetchedFrame::size() const {
  std::uint64_t bytes = file.size();
  for (const FetchedLayer& layer : layers) bytes += layer.bytes.size();
  return bytes;
}

Result<std::vector<FileRange>> ranges_of(const Manifest& manifest, std::uint32_t frame,
                                         const LayerRange& layers) {
  const FrameLocation place = locate(manifest, frame);
  const Segment& segment = manifest.segments[place.segment];
  const std::size_t end = std::min<std::size_t>(segment.layers.size(), std::max(1u, layers.end));
  std::vector<FileRange> ranges;
  std::uint64_t bytes = 0;
  for (std::size_t i = layers.first; i < end; ++i) {
    const LayerFile& file = segment.layers[i];
    Chunks<std::uint32_t> sizes = file.frames[place.index];
    if (!layers.normals) {
      sizes.normals = 0;
      if (!layers.colors) sizes.colors = 0;
    }
    bytes += total(sizes);
    ranges.push_back({&file, byte_range(file, place.index).offset, sizes});
  }
  if (bytes > kMaxFrameBytes)
    return fail(ErrorCode::limit, concat("the manifest says that frame ", frame, " takes ", bytes,
                                         " bytes; no more than ", kMaxFrameBytes, " are fetched"));
  return ranges;
}

}  // namespace pointreel
