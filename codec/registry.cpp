#include "codec/codec.h"
#include "codec/draco/draco_codec.h"
#include "codec/frame_header.h"
#include "codec/octree/octree_codec.h"

namespace pointreel {

Result<EncodedFrame> encode_frame(const PointCloud& cloud, const Cube& cube,
                                  const EncodeOptions& options) {
  if (const auto* octree = std::get_if<OctreeOptions>(&options.codec)) {
    return encode_octree(cloud, cube, *octree, options.normals, options.colors, options.executor);
  }
  return encode_draco(cloud, cube, std::get<DracoOptions>(options.codec), options.normals,
                      options.colors);
}

std::vector<LayerView> layer_views(std::span<const EncodedLayer> layers) {
  std::vector<LayerView> views;
  for (const EncodedLayer& layer : layers) {
    views.push_back({layer.geometry, layer.colors, layer.normals});
  }
  return views;
}

Result<DecodedFrame> decode_frame(const std::vector<LayerView>& layers,
                                  const DecodeLimits& limits) {
  if (layers.empty()) return fail("a frame has at least its base layer");
  const auto header = read_frame_header(layers.front().geometry);
  if (!header) return tl::unexpected(header.error());
  return header->header.codec == Codec::octree ? decode_octree(layers, limits)
                                               : decode_draco(layers, limits);
}

Result<PartSizes> measure_parts(const EncodedFrame& frame, const PointCloud& cloud,
                                const Cube& cube, const EncodeOptions& options) {
  if (const auto* draco = std::get_if<DracoOptions>(&options.codec)) {
    return measure_draco_parts(frame, cloud, cube, *draco, options.normals, options.colors);
  }
  PartSizes parts;
  for (const EncodedLayer& layer : frame.layers) {
    parts.geometry += layer.geometry.size();
    parts.colors += layer.colors.size();
    parts.normals += layer.normals.size();
  }
  return parts;
}

const char* name(Codec codec) { return codec == Codec::octree ? "octree" : "draco"; }

const char* name(Entropy entropy) {
  return entropy == Entropy::none ? "none" : entropy == Entropy::zstd ? "zstd" : "context";
}

}  // namespace pointreel
