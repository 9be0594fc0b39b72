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

/// A frame as it was read: what a decoder of AV1 gets, and what there is besides.
struct CodedVideoFrame {
  std::shared_ptr<const VideoGroup> group;
  int index = 0;  ///< in the group; at 0, both videos begin anew
  BlockMask blocks;
  ByteView leftovers;      ///< as VideoGeometry::leftovers
  ByteView depth, colors;  ///< temporal units of AV1; without colours, those are empty
};

/// Reads the frames of a group, one after another: everything but AV1.
///
/// Trust: the bytes may be hostile. The memory that the whole decoding takes is bounded by
/// DecodeLimits::max_memory, counted from the size of the pictures and what is on in them. Any
/// bytes give a frame or an error.
class VideoFrameReader {
 public:
  /// Reads the next frame of a group, or the first one of a new group. The frame's views are of
  /// `chunks`. Frames whose colours are left out have none, and neither have those after them.
  ///
  /// Errors: `invalid` if the bytes are damaged, or are not those of the next frame; `limit` if the
  /// frame exceeds the limits. After an error, a group has to begin anew.
  Result<CodedVideoFrame> next(const Chunks<ByteView>& chunks, const DecodeLimits& limits = {});
  /// A group has to begin anew.
  void reset() { group_.reset(); }

 private:
  Result<CodedVideoFrame> read(const Chunks<ByteView>& chunks, const DecodeLimits& limits);
  Result<void> begin(ByteView header, const DecodeLimits& limits);

  std::shared_ptr<const VideoGroup> group_;
  std::optional<OccupancyCoder> occupancy_;
  bool colors_ = false;
  int next_ = 0;
};

/// A decoded frame that has not been made into points yet.
struct VideoPictures {
  std::shared_ptr<const VideoGroup> group;
  BlockMask blocks;
  Av1Picture depth;
  std::optional<Av1Picture> colors;
  Bytes leftovers;  ///< as VideoGeometry::leftovers
};

/// The same without its videos' pictures, which are to be filled in.
VideoPictures undecoded(CodedVideoFrame frame);

/// A frame for players: a cloud with normals and radii, of fewer points where
/// DecodeLimits::spacing allows it. Errors: those of decode_octree, for the leftovers.
Result<DecodedFrame> frame_of(const VideoPictures& pictures, const DecodeLimits& limits = {});

/// The points of a frame. Their normals, if wanted, are those of the surface that the pictures
/// show. Errors: as above.
Result<PointCloud> points_of(const VideoPictures& pictures, const DecodeLimits& limits = {},
                             bool normals = true);

}  // namespace pointreel
