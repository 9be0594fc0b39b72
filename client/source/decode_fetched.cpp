#include "client/source/decode_fetched.h"

#include <cstdint>
#include <utility>
#include <vector>

#include "client/source/video_groups.h"
#include "codec/files/cloud_file.h"
#include "pointreel/chunks.h"
#include "pointreel/draco.h"
#include "pointreel/geometry.h"

namespace pointreel {

Result<DecodedFrame> decode_fetched(const FetchedFrame& fetched, DecodeLimits limits) {
  limits.tables = fetched.tables.get();
  if (fetched.layers.empty()) {
    const ByteView file = fetched.file.view();
    const CloudFormat format = fetched.file_format == CloudFormat::unknown
                                   ? format_of(file, fetched.file_name)
                                   : fetched.file_format;
    auto loaded = read_cloud(file, format, limits, fetched.reading ? *fetched.reading : Reading());
    if (!loaded) return fail_at(fetched.file_name, loaded.error());
    place(loaded->cloud, fetched.placement);
    DecodedFrame frame;
    frame.cloud = std::move(loaded->cloud);
    frame.cube = bounding_cube(bounds(frame.cloud));
    frame.source_points = static_cast<std::uint32_t>(frame.cloud.size());
    return frame;
  }
  if (const FetchedLayer& last = fetched.layers.back(); last.group)
    return decode_video(last, limits);
  std::vector<Chunks<ByteView>> views;
  for (const FetchedLayer& layer : fetched.layers) views.push_back(layer.view());
  return decode_frame(views, limits);
}

}  // namespace pointreel
