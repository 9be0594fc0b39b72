#include "codec/draco/draco_codec.h"
#include "codec/octree/frame_header.h"
#include "common/base/out_of_memory.h"
#include "common/base/try.h"
#include "pointreel/draco.h"

namespace pointreel {

Result<EncodedFrame> encode_frame(const PointCloud& cloud, const Cube& cube,
                                  const EncodeOptions& options) {
  if (const auto* octree = std::get_if<OctreeOptions>(&options.codec)) {
    return encode_octree(cloud, cube, *octree, options.normals, options.colors, options.executor);
  }
  return or_out_of_memory([&] {
    return encode_draco(cloud, cube, std::get<DracoOptions>(options.codec), options.normals,
                        options.colors);
  });
}

Result<DecodedFrame> decode_frame(const std::vector<Chunks<ByteView>>& layers,
                                  const DecodeLimits& limits) {
  if (layers.empty()) return fail(ErrorCode::argument, "a frame needs at least its base layer");
  return or_out_of_memory([&]() -> Result<DecodedFrame> {
    const Codec codec = TRY(read_frame_header(layers.front().geometry)).header.codec;
    return codec == Codec::octree ? decode_octree(layers, limits) : decode_draco(layers, limits);
  });
}

}  // namespace pointreel
