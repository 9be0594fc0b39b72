#include "codec/files/cloud_file.h"
#include "codec/octree/octree_codec.h"
#include "pointreel/draco.h"

// In place of Draco and files in the small module. The other module has both.

namespace pointreel {

Result<DecodedFrame> decode_frame(const std::vector<Chunks<ByteView>>& layers,
                                  const DecodeLimits& limits) {
  return decode_octree(layers, limits);
}

CloudFormat format_of(ByteView, std::string_view) { return CloudFormat::unknown; }

Result<LoadedCloud> read_cloud(ByteView, CloudFormat, const DecodeLimits&, const Reading&) {
  return fail(ErrorCode::unsupported, "is a file, which needs the larger module");
}

}  // namespace pointreel
