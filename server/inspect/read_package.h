#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include "codec/video/video_decoder.h"
#include "pointreel/chunks.h"
#include "pointreel/codec.h"
#include "pointreel/error.h"
#include "pointreel/package.h"
#include "server/inspect/inspect.h"

/// What verify and unpack share.
///
/// Trust: the files may be hostile. A layer takes no more memory than the manifest says, which is
/// compared with the file's size first; decoding is bounded as pointreel/draco.h says.
namespace pointreel {

/// One layer of a frame; its chunks are empty if the frame does not have it. The error does not
/// name the file.
Result<Chunks<Bytes>> read_layer(const PackageFiles& files, const Manifest& manifest,
                                 std::uint32_t frame, std::size_t layer);

/// Reads context tables of a package. `tables.bytes` is at most kMaxTablesBytes. The error does not
/// name the file.
Result<std::shared_ptr<const ContextTables>> read_tables(const std::filesystem::path& folder,
                                                         const PackageFile& tables);

/// Decodes the frames of one package.
class FrameDecoder {
 public:
  /// Without tables, as in a package that has none of its own. `max_memory`: as in DecodeLimits.
  explicit FrameDecoder(std::uint64_t max_memory) : max_memory_(max_memory) {}
  /// Reads the package's context tables. The error does not name the file.
  Result<void> read_tables(const PackageFiles& files, const PackageFile& tables);

  Result<DecodedFrame> decode(const std::vector<Chunks<ByteView>>& layers) const;
  /// The points of a frame of video, for which those before it in its group are decoded, too,
  /// unless this thread has done so for the last one that it asked for. The error does not name the
  /// file. `voxels`: instead of points, their surface_voxels.
  Result<PointCloud> decode_video(const PackageFiles& files, const Manifest& manifest,
                                  std::uint32_t frame, bool voxels = false) const;

 private:
  /// What a thread goes on with.
  struct VideoPlace {
    VideoDecoder decoder;
    std::optional<std::uint32_t> next;  ///< the frame that the decoder is ready for
  };

  std::uint64_t max_memory_;
  mutable tbb::enumerable_thread_specific<VideoPlace> video_;
  std::shared_ptr<const ContextTables> tables_;
};

/// Calls `work(i)` in parallel for 0 <= i < n, until the listener asks to stop.
template <class Work>
void for_each_frame(std::uint32_t n, const InspectListener& listener, const Work& work) {
  std::mutex mutex;
  tbb::parallel_for(std::uint32_t{0}, n, [&](std::uint32_t i) {
    if (listener.stop.stop_requested()) return;
    work(i);
    const std::lock_guard lock(mutex);
    if (listener.frame_done) listener.frame_done();
  });
}

}  // namespace pointreel
