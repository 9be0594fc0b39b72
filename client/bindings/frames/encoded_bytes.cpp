#include "client/bindings/frames/encoded_bytes.h"

#include <array>
#include <cstdint>
#include <utility>

#include "codec/files/cloud_format.h"
#include "codec/live/live.h"
#include "common/base/concat.h"
#include "common/base/out_of_memory.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

Result<FetchedFrame> layers_of(ByteView bytes, std::uint32_t most) {
  FetchedFrame fetched;
  std::uint8_t layers = 0;
  while (!bytes.empty()) {
    const LiveLayer layer = TRY(next_live_layer(bytes));
    if (fetched.layers.empty()) layers = layer.layers;
    if (layer.layer != fetched.layers.size() || layer.layers != layers)
      return fail(concat("layer ", static_cast<int>(layer.layer), " of ",
                         static_cast<int>(layer.layers), " is out of place"));
    fetched.layers.push_back({Bytes(layer.bytes.begin(), layer.bytes.end()), layer.sizes});
  }
  if (fetched.layers.empty()) return fail("there are no bytes");
  if (fetched.layers.size() > most) fetched.layers.resize(most);
  return fetched;
}

}  // namespace

Result<Bytes> frame_bytes(const EncodedFrame& frame) {
  Bytes bytes;
  bytes.reserve(frame.size() + frame.layers.size() * kLiveHeaderSize);
  LiveLayer header;
  header.layers = static_cast<std::uint8_t>(frame.layers.size());
  header.points = frame.source_points;
  for (const Chunks<Bytes>& layer : frame.layers) {
    if (total(layer) > kMaxLiveLayer - kLiveHeaderSize)
      return fail(ErrorCode::limit, concat("a layer of the frame takes more than ", kMaxLiveLayer,
                                           " bytes; write it into a package"));
    header.sizes = {static_cast<std::uint32_t>(layer.geometry.size()),
                    static_cast<std::uint32_t>(layer.colors.size()),
                    static_cast<std::uint32_t>(layer.normals.size())};
    const Bytes written = write_live_header(header);
    for (const Bytes* part : {&written, &layer.geometry, &layer.colors, &layer.normals})
      bytes.insert(bytes.end(), part->begin(), part->end());
    ++header.layer;
  }
  return bytes;
}

Result<SharedFrame> decode_bytes(ByteView bytes, const ReadLimits& limits) {
  if (limits.layers == 0) return fail(ErrorCode::argument, "a frame has at least one layer");
  return or_out_of_memory([&]() -> Result<SharedFrame> {
    FetchedFrame fetched;
    if (format_of(bytes, {}) != CloudFormat::unknown) {
      fetched.file = Bytes(bytes.begin(), bytes.end());
      fetched.file_name = "the file";
    } else {
      fetched = TRY(layers_of(bytes, limits.layers));
    }
    return decode_points(std::move(fetched), {}, limits);
  });
}

}  // namespace pointreel
