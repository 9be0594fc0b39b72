#include "server/inspect/read_package.h"

#include <algorithm>
#include <fstream>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "codec/octree/frame_header.h"
#include "codec/package/max_error.h"
#include "codec/video/surface_voxels.h"
#include "codec/video/video_frame.h"
#include "common/base/try.h"
#include "common/file_system/open_file.h"
#include "common/threads/tbb_executor.h"
#include "pointreel/draco.h"

namespace pointreel {
namespace fs = std::filesystem;

Result<Chunks<Bytes>> read_layer(const PackageFiles& files, const Manifest& manifest,
                                 std::uint32_t frame, std::size_t layer) {
  const FrameLocation at = locate(manifest, frame);
  const LayerFile& file = manifest.segments[at.segment].layers[layer];
  const Chunks<std::uint32_t>& sizes = file.frames[at.index];
  const ByteRange range = byte_range(file, at.index);
  const fs::path path = TRY(files.local(file));
  std::error_code error;
  const std::uintmax_t size = fs::file_size(path, error);
  if (error) return fail(ErrorCode::io, error.message());
  if (range.offset + range.size > size) {
    return fail(fmt::format("is cut off before the end of frame {}", frame));
  }
  std::ifstream in = TRY(open_stream(path));
  in.seekg(static_cast<std::streamoff>(range.offset));
  Chunks<Bytes> chunks;
  chunks.geometry.resize(sizes.geometry);
  chunks.colors.resize(sizes.colors);
  chunks.normals.resize(sizes.normals);
  for (Bytes* chunk : {&chunks.geometry, &chunks.colors, &chunks.normals}) {
    in.read(reinterpret_cast<char*>(chunk->data()), static_cast<std::streamsize>(chunk->size()));
  }
  if (!in) return fail(ErrorCode::io, "cannot be read");
  return chunks;
}

Result<std::vector<Chunks<Bytes>>> read_frame(const PackageFiles& files, const Manifest& manifest,
                                              std::uint32_t frame, std::size_t layers) {
  const std::vector<LayerFile>& listed = manifest.segments[locate(manifest, frame).segment].layers;
  std::vector<Chunks<Bytes>> read;
  for (std::size_t i = 0; i < std::min(layers, listed.size()); ++i) {
    Result<Chunks<Bytes>> layer = read_layer(files, manifest, frame, i);
    if (!layer) return fail_at(files.shown(listed[i]), layer.error());
    if (layer->geometry.empty()) break;
    read.push_back(std::move(*layer));
  }
  return read;
}

Result<std::shared_ptr<const ContextTables>> read_tables(const fs::path& folder,
                                                         const PackageFile& tables) {
  std::ifstream in = TRY(open_stream(folder / tables.path));
  Bytes bytes(tables.bytes);
  in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!in) return fail(ErrorCode::io, "cannot be read, or is cut off");
  return read_table_file(bytes);
}

Result<void> FrameDecoder::read_tables(const PackageFiles& files, const PackageFile& tables) {
  const fs::path path = TRY(files.local(tables));
  tables_ = TRY(
      pointreel::read_tables(path.parent_path(), tables));  // parse_manifest has bounded their size
  return {};
}

Result<DecodedFrame> FrameDecoder::decode(const std::vector<Chunks<ByteView>>& layers) const {
  DecodeLimits limits;
  limits.max_memory = max_memory_;
  limits.tables = tables_.get();
  limits.executor = tbb_executor();
  return decode_frame(layers, limits);
}

Result<PointCloud> FrameDecoder::decode_video(const PackageFiles& files, const Manifest& manifest,
                                              std::uint32_t frame, bool voxels) const {
  const std::uint32_t begin = group_of(manifest, frame).first;
  DecodeLimits limits;
  limits.max_memory = max_memory_;
  limits.executor = tbb_executor();
  VideoPlace& place = video_.local();
  const std::optional<std::uint32_t> ready = std::exchange(place.next, std::nullopt);
  const bool goes_on = ready && *ready >= begin && *ready <= frame;
  for (std::uint32_t i = goes_on ? *ready : begin;; ++i) {
    const Chunks<Bytes> chunks = TRY(read_layer(files, manifest, i, 1));
    const VideoPictures pictures =
        TRY(place.decoder.next({chunks.geometry, chunks.colors, {}}, limits));
    if (i < frame) continue;
    place.next = frame + 1;
    PointCloud points = TRY(points_of(pictures, limits));
    return voxels ? surface_voxels(points, pictures.group->pitch, limits.executor) : points;
  }
}

Result<double> max_error(const PackageFiles& files, const Manifest& manifest) {
  if (manifest.max_error) return *manifest.max_error;
  double largest = 0.0;
  for (const Segment& segment : manifest.segments) {
    const LayerFile& base = segment.layers.front();
    const std::string path = TRY(files.local(base)).string();
    std::ifstream in = TRY(at_place(path, open_stream(path)));
    std::uint64_t offset = 0;
    Bytes bytes(kFrameHeaderSize);
    for (const Chunks<std::uint32_t>& sizes : base.frames) {
      in.seekg(static_cast<std::streamoff>(offset));
      in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
      if (!in) return fail(ErrorCode::io, path + ": cannot be read");
      const Result<ParsedFrameHeader> parsed = read_frame_header(bytes);
      if (!parsed) return fail_at(path, parsed.error());
      const FrameHeader& header = parsed->header;
      if (header.coded_points > 0) {
        largest = std::max(largest, max_geometry_error(header.cube, header.depth));
      }
      offset += total(sizes);
    }
  }
  return largest;
}

}  // namespace pointreel
