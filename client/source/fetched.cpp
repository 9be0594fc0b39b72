#include "client/source/fetched.h"

#include <algorithm>

#include "common/base/concat.h"

namespace pointreel {

Chunks<ByteView> chunk_views(ByteView bytes, const Chunks<std::uint32_t>& sizes) {
  return {bytes.subspan(0, sizes.geometry), bytes.subspan(sizes.geometry, sizes.colors),
          bytes.subspan(std::size_t{sizes.geometry} + sizes.colors, sizes.normals)};
}

Chunks<ByteView> FetchedGroup::view(std::size_t index) const {
  std::uint64_t offset = 0;
  for (std::size_t i = 0; i < index; ++i) offset += total(sizes[i]);
  return chunk_views(bytes.view().subspan(offset, total(sizes[index])), sizes[index]);
}

std::uint64_t FileRange::bytes() const {
  if (group.empty()) return total(sizes);
  std::uint64_t sum = 0;
  for (const Chunks<std::uint32_t>& of_frame : group) sum += total(of_frame);
  return sum;
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

namespace {

/// Video is fetched by whole groups. `frame` is the frame's index in the file, `before` how many
/// of the group are before it.
FileRange group_range(const LayerFile& file, std::uint32_t frame, std::uint32_t before,
                      std::uint32_t frames) {
  const std::uint32_t first = frame - before;
  return {&file, byte_range(file, first).offset, file.frames[frame],
          std::span(file.frames).subspan(first, frames), before};
}

}  // namespace

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
    if (i > 0 && manifest.group_frames > 0) {
      const FrameGroup group = group_of(manifest, frame);
      ranges.push_back(group_range(file, place.index, frame - group.first, group.frames));
      bytes += ranges.back().bytes();
      continue;
    }
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
