#include "client/source/source.h"

#include <algorithm>

#include <fmt/format.h>

#include "codec/octree/context_tables.h"
#include "pointreel/chunks.h"

namespace pointreel {

Chunks<ByteView> FetchedLayer::view() const {
  const ByteView all(bytes);
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

Result<std::vector<LayerRange>> ranges_of(const Manifest& manifest, std::uint32_t frame,
                                          const FetchRequest& request) {
  const FrameLocation place = locate(manifest, frame);
  const Segment& segment = manifest.segments[place.segment];
  const std::size_t count =
      std::min<std::size_t>(segment.layers.size(), std::max(1u, request.layers));
  std::vector<LayerRange> ranges;
  std::uint64_t bytes = 0;
  for (std::size_t i = request.first_layer; i < count; ++i) {
    const LayerFile& file = segment.layers[i];
    Chunks<std::uint32_t> sizes = file.frames[place.index];
    if (!request.normals) {
      sizes.normals = 0;
      if (!request.colors) sizes.colors = 0;
    }
    bytes += total(sizes);
    ranges.push_back({&file, byte_range(file, place.index).offset, sizes});
  }
  if (bytes > kMaxFrameBytes)
    return fail(
        fmt::format("the manifest says that the frame takes {} bytes; more than {} are not fetched",
                    bytes, kMaxFrameBytes));
  return ranges;
}

}  // namespace pointreel
