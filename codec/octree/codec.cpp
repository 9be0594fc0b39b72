#include "pointreel/codec.h"

namespace pointreel {

std::vector<Chunks<ByteView>> layer_views(std::span<const Chunks<Bytes>> layers) {
  std::vector<Chunks<ByteView>> views;
  for (const Chunks<Bytes>& layer : layers) {
    views.push_back({layer.geometry, layer.colors, layer.normals});
  }
  return views;
}

const char* name(Codec codec) {
  switch (codec) {
    case Codec::octree:
      return "octree";
    case Codec::draco:
      return "draco";
    case Codec::video:
      return "video";
  }
  return "";
}

const char* name(Entropy entropy) {
  return entropy == Entropy::none ? "none" : entropy == Entropy::zstd ? "zstd" : "context";
}

}  // namespace pointreel
