#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "codec/octree/frame_header.h"
#include "codec/package/manifest.h"
#include "common/base/try.h"
#include "common/base/words.h"
#include "common/threads/without_exceptions.h"
#include "server/inspect/inspect.h"
#include "server/inspect/read_package.h"
#include "server/pack/audio.h"
#include "server/store/check_file.h"

namespace pointreel {
namespace fs = std::filesystem;
namespace {

Result<void> check_file(const PackageFiles& files, const PackageFile& file) {
  const fs::path path = TRY(files.local(file));
  TRY(check_size(path, file));
  return check_checksum(path, file);
}

/// The layer that keeps a frame from being decoded: the last one of the shortest prefix that fails.
std::size_t layer_at_fault(const FrameDecoder& decoder, std::vector<Chunks<ByteView>> layers) {
  while (layers.size() > 1 && !decoder.decode({layers.begin(), layers.end() - 1})) {
    layers.pop_back();
  }
  return layers.size() - 1;
}

/// How many cells of the octree below it video may move a point. Strong quantisers move some points
/// of clouds that are no surfaces by a tenth of the cube.
constexpr double kVideoCells = 16.0;

/// Whether the points lie within the bounds, which are those of the source: coding moves a point by
/// up to so many cells.
bool is_within(const Box& box, const PointCloud& cloud, const FrameHeader& header,
               double cells = 1.0) {
  const Box points = bounds(cloud);
  if (points.empty()) return true;
  const double cell = cells * std::ldexp(header.cube.edge, -header.depth);
  const glm::dvec3 reach = glm::max(glm::abs(points.min), glm::abs(points.max));
  const glm::dvec3 margin = cell + 1e-6 * reach;
  return !box.empty() && glm::all(glm::greaterThanEqual(points.min, box.min - margin)) &&
         glm::all(glm::lessThanEqual(points.max, box.max + margin));
}

/// Compares a decoded frame with what the manifest and its own header say.
Result<void> check_decoded(const Manifest& manifest, std::uint32_t frame, std::size_t layers,
                           const FrameHeader& header, const DecodedFrame& decoded) {
  const FrameLocation at = locate(manifest, frame);
  const std::uint32_t points = manifest.segments[at.segment].points[at.index];
  if (manifest.codec != name(manifest.group_frames > 0 ? Codec::video : header.codec)) {
    return fail(fmt::format("is a frame of the {} codec", name(header.codec)));
  }
  if (decoded.source_points != points) {
    return fail(fmt::format("was made of {}, the manifest says {}",
                            counted(decoded.source_points, "point"), points));
  }
  // Fewer layers may decode to the same number of points, if the finer ones divide no cell.
  const bool coarser = manifest.partial && layers < header.layers;
  const std::size_t all = header.layers + (decoded.cloud.has_scalars() ? 1u : 0u);
  if (layers != all && !coarser) {
    return fail(fmt::format("has {}, its header says {}: a layer is missing",
                            counted(layers, "layer"), all));
  }
  if (!coarser && decoded.cloud.size() != header.coded_points) {
    return fail(fmt::format("decodes to {}, its header says {}",
                            counted(decoded.cloud.size(), "point"), header.coded_points));
  }
  if (!coarser && !is_within(manifest.bounds, decoded.cloud, header))
    return fail("has points outside of the manifest's bounds");
  if (header.depth < manifest.depth_min || header.depth > manifest.depth_max) {
    return fail(fmt::format("has depth {}, the manifest says {} to {}", header.depth,
                            manifest.depth_min, manifest.depth_max));
  }
  return {};
}

/// The first fault of a frame, if there is one.
std::optional<Fault> fault_of(const PackageFiles& files, const Manifest& manifest,
                              const FrameDecoder& decoder, std::uint32_t frame) {
  const std::vector<LayerFile>& listed = manifest.segments[locate(manifest, frame).segment].layers;
  const auto fault = [&](std::size_t layer, const Error& error) {
    return Fault{listed[layer].path, frame, error.message};
  };
  std::vector<Chunks<Bytes>> layers;
  for (std::size_t i = 0; i < listed.size(); ++i) {
    Result<Chunks<Bytes>> layer = read_layer(files, manifest, frame, i);
    if (!layer) return fault(i, layer.error());
    if (layer->geometry.empty()) break;
    layers.push_back(std::move(*layer));
  }
  const Result<ParsedFrameHeader> parsed = read_frame_header(layers.front().geometry);
  if (!parsed) return fault(0, parsed.error());
  const std::optional<std::size_t> video =
      manifest.group_frames > 0 ? std::optional<std::size_t>(1) : std::nullopt;
  if (video && layers.size() <= *video) return fault(*video, Error{"has no video"});
  if (video) layers.resize(*video);
  const Result<DecodedFrame> decoded = decoder.decode(layer_views(layers));
  if (!decoded) return fault(layer_at_fault(decoder, layer_views(layers)), decoded.error());
  const Result<void> checked =
      check_decoded(manifest, frame, layers.size(), parsed->header, *decoded);
  if (!checked) return fault(layers.size() - 1, checked.error());
  if (!video) return std::nullopt;
  const Result<PointCloud> points = decoder.decode_video(files, manifest, frame);
  if (!points) return fault(*video, points.error());
  if (!is_within(manifest.bounds, *points, parsed->header, kVideoCells))
    return fault(*video, Error{"has points outside of the manifest's bounds"});
  return std::nullopt;
}

/// Faults that are found in any order, by the number of their file or frame.
class Faults {
 public:
  void add(std::uint32_t number, Fault fault) {
    const std::lock_guard lock(mutex_);
    faults_.emplace_back(number, std::move(fault));
  }
  bool empty() const { return faults_.empty(); }
  void append_to(std::vector<Fault>& all) {
    std::sort(faults_.begin(), faults_.end(),
              [](const auto& a, const auto& b) { return a.first < b.first; });
    for (auto& [number, fault] : faults_) all.push_back(std::move(fault));
  }

 private:
  std::mutex mutex_;
  std::vector<std::pair<std::uint32_t, Fault>> faults_;
};

VerifyReport verify_parsed(const PackageFiles& files, const Manifest& manifest,
                           const InspectListener& listener, std::uint64_t max_memory) {
  VerifyReport report;
  report.frames = manifest.frame_count();
  const std::vector<const PackageFile*> listed = manifest.files();
  for (const PackageFile* file : listed) report.bytes += file->bytes;
  report.files = static_cast<std::uint32_t>(listed.size());
  if (listener.begin) listener.begin(report.frames);

  Faults of_files, of_frames;
  tbb::parallel_for(std::uint32_t{0}, report.files, [&](std::uint32_t i) {
    if (listener.stop.stop_requested()) return;
    if (const Result<void> good = check_file(files, *listed[i]); !good) {
      of_files.add(i, {listed[i]->path, std::nullopt, good.error().message});
    }
  });
  FrameDecoder decoder(max_memory);
  if (manifest.tables) {
    const auto read = decoder.read_tables(files, *manifest.tables);
    // Otherwise a fault of the file has been reported already.
    if (!read && of_files.empty()) {
      of_files.add(0, {manifest.tables->path, std::nullopt, read.error().message});
    }
  }
  if (manifest.audio) {
    const auto checked = check_audio(files, *manifest.audio);
    if (!checked && of_files.empty()) {
      of_files.add(0, {manifest.audio->path, std::nullopt, checked.error().message});
    }
  }
  for_each_frame(report.frames, listener, [&](std::uint32_t i) {
    if (std::optional<Fault> fault = fault_of(files, manifest, decoder, i)) {
      of_frames.add(i, std::move(*fault));
    }
  });
  of_files.append_to(report.faults);
  of_frames.append_to(report.faults);
  return report;
}

}  // namespace

Result<VerifyReport> verify(const PackageFiles& files, const InspectListener& listener,
                            std::uint64_t max_memory) {
  return without_exceptions([&]() -> Result<VerifyReport> {
    VerifyReport report = verify_parsed(files, TRY(files.manifest()), listener, max_memory);
    if (listener.stop.stop_requested()) return fail(ErrorCode::cancelled, "interrupted");
    if (const auto error = files.lacks_room()) return tl::unexpected(*error);
    return report;
  });
}

}  // namespace pointreel
