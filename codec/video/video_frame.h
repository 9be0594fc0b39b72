#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "codec/video/av1_decoder.h"
#include "codec/video/occupancy.h"
#include "codec/video/video_group.h"
#include "pointreel/bytes.h"
#include "pointreel/chunks.h"
#include "pointreel/codec.h"
#include "pointreel/error.h"

/// The frames of layered depth videos: FORMAT.md, "Video".
namespace pointreel {

/// What the geometry of a frame consists of.
struct VideoGeometry {
  Bytes group;      ///< write_video_group; empty but in the first frame of a group
  Bytes occupancy;  ///< OccupancyCoder
  Bytes leftovers;  ///< an octree frame of the points that no view holds, or empty
  Bytes depth;      ///< a temporal unit of AV1
};

/// The chunks of frame `index` of a group. `colors`: a temporal unit of AV1, or empty.
Chunks<Bytes> video_chunks(int index, const VideoGeometry& geometry, const Bytes& colors);

/// A decoded frame that has not been made into points yet.
struct VideoPictures {
  std::shared_ptr<const VideoGroup> group;
  BlockMask blocks;
  Av1Picture depth;
  std::optional<Av1Picture> colors;
  Bytes leftovers;  ///< as VideoGeometry::leftovers
};

/// Decodes the frames of a group, one after another.
///
/// Trust: the bytes may be hostile. Memory is bounded by DecodeLimits::max_memory, counted from the
/// size of the pictures before any is decoded. Any bytes give pictures or an error.
class VideoDecoder {
 public:
  VideoDecoder();
  VideoDecoder(VideoDecoder&&) noexcept;
  VideoDecoder& operator=(VideoDecoder&&) noexcept;
  ~VideoDecoder();

  /// Decodes the next frame of a group, or the first one of a new group. Frames whose colours are
  /// left out have none, and neither have those after them.
  ///
  /// Errors: `invalid` if the bytes are damaged, or are not those of the next frame; `limit` if the
  /// frame exceeds the limits. After an error, a group has to begin anew.
  Result<VideoPictures> next(const Chunks<ByteView>& chunks, const DecodeLimits& limits = {});

 private:
  class Group;
  std::unique_ptr<Group> group_;
};

/// The points of a frame. Their normals, if wanted, are those of the surface that the pictures
/// show. Errors: those of decode_octree, for the leftovers.
Result<PointCloud> points_of(const VideoPictures& pictures, const DecodeLimits& limits = {},
                             bool normals = true);

}  // namespace pointreel
