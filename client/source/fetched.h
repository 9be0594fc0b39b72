#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "client/source/shared_bytes.h"
#include "codec/core/placement.h"
#include "codec/files/cloud_format.h"
#include "codec/files/reading.h"
#include "pointreel/bytes.h"
#include "pointreel/chunks.h"
#include "pointreel/codec.h"
#include "pointreel/error.h"
#include "pointreel/package.h"

/// What is fetched of a frame, and where it is in a package. Without threads, links and files, so
/// that a browser's player can use it.
namespace pointreel {

inline constexpr std::uint32_t kAllLayers = ~0u;

/// Consecutive layers of a frame, and which of their attributes. A layer's chunks are stored in the
/// order geometry, colours, normals, and a fetch takes a prefix of them: normals bring the colours
/// with them.
struct LayerRange {
  std::uint32_t first = 0, end = kAllLayers;  ///< layers [first, end); the base is layer 0
  bool colors = true, normals = true;

  bool operator==(const LayerRange&) const = default;
};

/// Views of chunks of these sizes, which follow each other in `bytes`.
Chunks<ByteView> chunk_views(ByteView bytes, const Chunks<std::uint32_t>& sizes);

/// The video of a group of frames as it was fetched.
struct FetchedGroup {
  SharedBytes bytes;
  std::vector<Chunks<std::uint32_t>> sizes;  ///< of each frame's chunks

  Chunks<ByteView> view(std::size_t index) const;
};

/// One layer of a frame as it was fetched.
struct FetchedLayer {
  SharedBytes bytes;
  /// Of the chunks in `bytes`, which hold them in the stored order; 0 for a chunk not fetched.
  Chunks<std::uint32_t> sizes;
  /// Of video: the group that the frame belongs to, whose bytes `bytes` are a part of, and the
  /// frame's number in it. Null for what decodes alone.
  std::shared_ptr<const FetchedGroup> group = nullptr;
  std::uint32_t index = 0;

  Chunks<ByteView> view() const { return chunk_views(bytes.view(), sizes); }
};

/// A frame as it came: either layers of a package, or a whole file of points. Copying it copies
/// none of their bytes.
struct FetchedFrame {
  std::vector<FetchedLayer> layers;
  std::shared_ptr<const ContextTables> tables;     ///< of the package that has `layers`, or null
  SharedBytes file;                                ///< used if `layers` is empty
  std::string file_name;                           ///< of `file`, for errors and for its format
  CloudFormat file_format = CloudFormat::unknown;  ///< or else by its first bytes and its name
  std::shared_ptr<const Reading> reading;          ///< of `file`; null: by the file alone
  Placement placement = {};                        ///< of the points of `file`

  std::uint64_t size() const;  ///< bytes that came
};

/// The part of a layer's file that holds what is wanted of a frame.
struct FileRange {
  const LayerFile* file = nullptr;  ///< in the manifest
  std::uint64_t offset = 0;
  Chunks<std::uint32_t> sizes;
  /// Of video: the sizes of all frames of the group, which `offset` is the begin of. Otherwise
  /// empty.
  std::span<const Chunks<std::uint32_t>> group = {};
  std::uint32_t index = 0;  ///< of the frame in its group

  std::uint64_t bytes() const;
};

/// No frame of any real reel comes near this; a manifest that says otherwise is not believed.
inline constexpr std::uint64_t kMaxFrameBytes = std::uint64_t{1} << 30;

/// The ranges to fetch, in the order of the layers; at least the base's. An error if they exceed
/// kMaxFrameBytes.
Result<std::vector<FileRange>> ranges_of(const Manifest& manifest, std::uint32_t frame,
                                         const LayerRange& layers);

/// A package's tables, from the bytes of the file that its manifest lists. An error if they are not
/// that file's bytes. Trust: the bytes may be hostile; context_tables.h says how they are read.
Result<std::shared_ptr<const ContextTables>> read_tables(const PackageFile& file, ByteView bytes);

}  // namespace pointreel
