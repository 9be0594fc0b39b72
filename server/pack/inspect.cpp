#include "server/pack/inspect.h"

#include <algorithm>
#include <array>
#include <exception>
#include <fstream>
#include <memory>
#include <mutex>
#include <new>
#include <utility>

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <xxhash.h>

#include "codec/frame_header.h"
#include "codec/max_error.h"
#include "codec/octree/context_tables.h"
#include "common/base/tbb_executor.h"
#include "common/cloud/ply.h"
#include "common/stream/manifest.h"
#include "pointreel/chunks.h"
#include "pointreel/draco.h"
#include "server/pack/output_folder.h"

namespace pointreel {
namespace fs = std::filesystem;
namespace {

constexpr const char* kInterrupted = "interrupted";

/// One layer of a frame; empty where the frame does not have it. The error does not name the file.
Result<Chunks<Bytes>> read_layer(const fs::path& folder, const Manifest& manifest,
                                 std::uint32_t frame, std::size_t layer) {
  const FrameLocation at = locate(manifest, frame);
  const LayerFile& file = manifest.segments[at.segment].layers[layer];
  const Chunks<std::uint32_t>& sizes = file.frames[at.index];
  const ByteRange range = byte_range(file, at.index);
  std::error_code error;
  const std::uintmax_t size = fs::file_size(folder / file.path, error);
  if (error) return fail(error.message());
  if (range.offset + range.size > size) {
    return fail(fmt::format("is cut off before the end of frame {}", frame));
  }
  std::ifstream in(folder / file.path, std::ios::binary);
  in.seekg(static_cast<std::streamoff>(range.offset));
  Chunks<Bytes> bytes;
  bytes.geometry.resize(sizes.geometry);
  bytes.colors.resize(sizes.colors);
  bytes.normals.resize(sizes.normals);
  for (Bytes* part : {&bytes.geometry, &bytes.colors, &bytes.normals}) {
    in.read(reinterpret_cast<char*>(part->data()), static_cast<std::streamsize>(part->size()));
  }
  if (!in) return fail("cannot be read");
  return bytes;
}

Result<std::uint64_t> file_checksum(const fs::path& path) {
  const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> hash(XXH3_createState(),
                                                                      &XXH3_freeState);
  XXH3_64bits_reset(hash.get());
  std::ifstream in(path, std::ios::binary);
  std::vector<char> block(1 << 20);
  while (in) {
    in.read(block.data(), static_cast<std::streamsize>(block.size()));
    XXH3_64bits_update(hash.get(), block.data(), static_cast<std::size_t>(in.gcount()));
  }
  if (!in.eof()) return fail("cannot be read");
  return XXH3_64bits_digest(hash.get());
}

Result<std::shared_ptr<const ContextTables>> load_tables(const fs::path& folder,
                                                         const PackageFile& file) {
  std::ifstream in(folder / file.path, std::ios::binary);
  Bytes bytes(file.bytes);  // parse_manifest bounds it
  in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!in) return fail("cannot be read, or is cut off");
  return read_table_file(bytes);
}

/// What is wrong with a file as a whole, if anything.
Result<void> check_file(const fs::path& folder, const PackageFile& file) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(folder / file.path, error);
  if (error) return fail(error.message());
  if (size != file.bytes) {
    return fail(fmt::format("has {} bytes, the manifest says {}", size, file.bytes));
  }
  const Result<std::uint64_t> checksum = file_checksum(folder / file.path);
  if (!checksum) return tl::unexpected(checksum.error());
  if (*checksum != file.checksum) {
    return fail(fmt::format("has the checksum {:016x}, the manifest says {:016x}", *checksum,
                            file.checksum));
  }
  return {};
}

/// What decoding a package's frames takes.
struct Decoder {
  std::shared_ptr<const ContextTables> tables;

  Result<DecodedFrame> operator()(const std::vector<Chunks<ByteView>>& layers) const {
    DecodeLimits limits;
    limits.tables = tables.get();
    limits.executor = tbb_executor();
    return decode_frame(layers, limits);
  }
};

/// The layer that keeps a frame from being decoded: the last of its shortest prefix that fails.
std::size_t layer_at_fault(const Decoder& decode, std::vector<Chunks<ByteView>> layers) {
  while (layers.size() > 1 && !decode({layers.begin(), layers.end() - 1})) layers.pop_back();
  return layers.size() - 1;
}

/// A frame that decodes, against what the manifest and its own header promise.
Result<void> check_promises(const Manifest& manifest, std::uint32_t frame, std::size_t layers,
                            const FrameHeader& header, const DecodedFrame& decoded) {
  const FrameLocation at = locate(manifest, frame);
  const std::uint32_t points = manifest.segments[at.segment].points[at.index];
  if (manifest.codec != name(header.codec)) {
    return fail(fmt::format("is a frame of the {} codec", name(header.codec)));
  }
  if (decoded.source_points != points) {
    return fail(
        fmt::format("was made of {} points, the manifest says {}", decoded.source_points, points));
  }
  // Fewer layers may decode to as many points, where the finer ones divide no cell.
  const bool coarser = manifest.partial && layers < header.layers;
  if (layers != header.layers && !coarser) {
    return fail(fmt::format("has {} layers, its header says {}: a layer is missing", layers,
                            header.layers));
  }
  if (!coarser && decoded.cloud.size() != header.coded_points) {
    return fail(fmt::format("decodes to {} points, its header says {}", decoded.cloud.size(),
                            header.coded_points));
  }
  if (header.depth < manifest.depth_min || header.depth > manifest.depth_max) {
    return fail(fmt::format("has depth {}, the manifest says {} to {}", header.depth,
                            manifest.depth_min, manifest.depth_max));
  }
  return {};
}

/// What is wrong with a frame, if anything.
std::optional<Fault> fault_of(const fs::path& folder, const Manifest& manifest,
                              const Decoder& decode, std::uint32_t frame) {
  const std::vector<LayerFile>& files = manifest.segments[locate(manifest, frame).segment].layers;
  const auto fault = [&](std::size_t layer, const Error& error) {
    return Fault{files[layer].path, frame, error.message};
  };
  FrameBytes bytes;
  for (std::size_t layer = 0; layer < files.size(); ++layer) {
    Result<Chunks<Bytes>> read = read_layer(folder, manifest, frame, layer);
    if (!read) return fault(layer, read.error());
    if (read->geometry.empty()) break;
    bytes.layers.push_back(std::move(*read));
  }
  const Result<ParsedFrameHeader> parsed = read_frame_header(bytes.layers.front().geometry);
  if (!parsed) return fault(0, parsed.error());
  const Result<DecodedFrame> decoded = decode(layer_views(bytes.layers));
  if (!decoded) return fault(layer_at_fault(decode, layer_views(bytes.layers)), decoded.error());
  const Result<void> kept =
      check_promises(manifest, frame, bytes.layers.size(), parsed->header, *decoded);
  if (!kept) return fault(bytes.layers.size() - 1, kept.error());
  return std::nullopt;
}

/// Calls `work(i)` for 0 <= i < n side by side until `stop`.
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

VerifyReport verify_parsed(const fs::path& folder, const Manifest& manifest,
                           const InspectListener& listener) {
  VerifyReport report;
  report.frames = manifest.frame_count();
  const std::vector<const PackageFile*> files = manifest.files();
  for (const PackageFile* file : files) report.bytes += file->bytes;
  report.files = static_cast<std::uint32_t>(files.size());
  if (listener.begin) listener.begin(report.frames);

  std::mutex mutex;
  std::vector<std::pair<std::uint32_t, Fault>> of_files, of_frames;
  tbb::parallel_for(std::uint32_t{0}, report.files, [&](std::uint32_t i) {
    if (listener.stop.stop_requested()) return;
    if (const Result<void> good = check_file(folder, *files[i]); !good) {
      const std::lock_guard lock(mutex);
      of_files.push_back({i, {files[i]->path, std::nullopt, good.error().message}});
    }
  });
  Decoder decoder;
  if (manifest.tables) {
    auto tables = load_tables(folder, *manifest.tables);
    // A file that is not the manifest's has been found at fault already.
    if (tables) decoder.tables = std::move(*tables);
    if (!tables && of_files.empty()) {
      of_files.push_back({0, {manifest.tables->path, std::nullopt, tables.error().message}});
    }
  }
  for_each_frame(report.frames, listener, [&](std::uint32_t i) {
    if (std::optional<Fault> fault = fault_of(folder, manifest, decoder, i)) {
      const std::lock_guard lock(mutex);
      of_frames.push_back({i, std::move(*fault)});
    }
  });
  for (auto* faults : {&of_files, &of_frames}) {
    std::sort(faults->begin(), faults->end(),
              [](const auto& a, const auto& b) { return a.first < b.first; });
    for (auto& [order, fault] : *faults) report.faults.push_back(std::move(fault));
  }
  return report;
}

bool is_unpacked_frame(const std::string& name) {
  const std::string head = "frame_", tail = ".ply";
  return name.size() > head.size() + tail.size() && name.starts_with(head) &&
         name.ends_with(tail) &&
         std::all_of(name.begin() + static_cast<std::ptrdiff_t>(head.size()),
                     name.end() - static_cast<std::ptrdiff_t>(tail.size()),
                     [](char c) { return c >= '0' && c <= '9'; });
}

Result<void> may_replace_frames(const fs::path& folder) {
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (!is_unpacked_frame(name)) {
      return fail(fmt::format(
          "holds {}, --force replaces folders of unpacked frames only: remove it yourself", name));
    }
  }
  if (error) return fail(error.message());
  return {};
}

Result<void> unpack_frame(const UnpackOptions& options, const Manifest& manifest,
                          const Decoder& decode, std::uint32_t frame, const fs::path& path) {
  const Result<FrameBytes> bytes = read_frame(options.input, manifest, frame, options.layers);
  if (!bytes) return tl::unexpected(bytes.error());
  const Result<DecodedFrame> decoded = decode(layer_views(bytes->layers));
  if (!decoded) {
    return fail_at(fmt::format("{}: frame {}", options.input.string(), frame), decoded.error());
  }
  return write_ply(path, decoded->cloud);
}

Result<std::uint32_t> unpack_parsed(const UnpackOptions& options, const Manifest& manifest,
                                    const InspectListener& listener) {
  const std::uint32_t frames = manifest.frame_count();
  if (options.layers == 0 || options.first_frame > options.last_frame ||
      (options.first_frame >= frames && frames > 0)) {
    return fail(
        fmt::format("{}: has {} frames, numbered from 0, and {} layers, at least one of "
                    "each must be asked for",
                    options.input.string(), frames, manifest.layer_names.size()));
  }
  Decoder decoder;
  if (manifest.tables) {
    auto tables = load_tables(options.input, *manifest.tables);
    if (!tables) {
      return fail_at((options.input / manifest.tables->path).string(), tables.error());
    }
    decoder.tables = std::move(*tables);
  }
  Result<OutputFolder> folder = OutputFolder::create(
      options.output, options.force ? may_replace_frames : OutputFolder::MayReplace{});
  if (!folder) return tl::unexpected(folder.error());

  const std::uint32_t last = std::min<std::uint32_t>(options.last_frame, frames - 1);
  const std::uint32_t count = frames == 0 ? 0 : last - options.first_frame + 1;
  const std::size_t digits = std::max<std::size_t>(5, fmt::format("{}", last).size());
  if (listener.begin) listener.begin(count);
  std::mutex mutex;
  std::optional<std::pair<std::uint32_t, Error>> first_error;
  for_each_frame(count, listener, [&](std::uint32_t i) {
    const std::uint32_t frame = options.first_frame + i;
    const fs::path path = folder->path() / fmt::format("frame_{:0{}}.ply", frame, digits);
    if (const Result<void> done = unpack_frame(options, manifest, decoder, frame, path); !done) {
      const std::lock_guard lock(mutex);
      if (!first_error || frame < first_error->first) first_error = {frame, done.error()};
    }
  });
  if (first_error) return tl::unexpected(first_error->second);
  if (listener.stop.stop_requested()) return fail("interrupted, nothing was written");
  if (const Result<void> published = folder->publish(); !published) {
    return tl::unexpected(published.error());
  }
  return count;
}

/// Libraries below may throw, for want of memory most of all.
template <class Work>
auto without_exceptions(const Work& work) -> decltype(work()) {
  try {
    return work();
  } catch (const std::bad_alloc&) {
    return fail("not enough memory");
  } catch (const std::exception& e) {
    return fail(e.what());
  }
}

}  // namespace

Result<FrameBytes> read_frame(const fs::path& folder, const Manifest& manifest, std::uint32_t frame,
                              std::size_t layers) {
  const std::vector<LayerFile>& files = manifest.segments[locate(manifest, frame).segment].layers;
  FrameBytes bytes;
  for (std::size_t i = 0; i < std::min(layers, files.size()); ++i) {
    Result<Chunks<Bytes>> layer = read_layer(folder, manifest, frame, i);
    if (!layer) return fail_at((folder / files[i].path).string(), layer.error());
    if (layer->geometry.empty()) break;
    bytes.layers.push_back(std::move(*layer));
  }
  return bytes;
}

Result<double> max_error(const fs::path& folder, const Manifest& manifest) {
  double most = 0.0;
  for (const Segment& segment : manifest.segments) {
    const LayerFile& base = segment.layers.front();
    std::ifstream in(folder / base.path, std::ios::binary);
    std::uint64_t offset = 0;
    Bytes bytes(kFrameHeaderSize);
    for (const Chunks<std::uint32_t>& sizes : base.frames) {
      in.seekg(static_cast<std::streamoff>(offset));
      in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
      if (!in) return fail_at((folder / base.path).string(), {"cannot be read"});
      const Result<ParsedFrameHeader> parsed = read_frame_header(bytes);
      if (!parsed) return fail_at((folder / base.path).string(), parsed.error());
      const FrameHeader& header = parsed->header;
      if (header.coded_points > 0) {
        most = std::max(most, max_geometry_error(header.cube, header.depth));
      }
      offset += total(sizes);
    }
  }
  return most;
}

Result<VerifyReport> verify(const fs::path& folder, const InspectListener& listener) {
  return without_exceptions([&]() -> Result<VerifyReport> {
    const Result<Manifest> manifest = read_manifest(folder);
    if (!manifest) return tl::unexpected(manifest.error());
    VerifyReport report = verify_parsed(folder, *manifest, listener);
    if (listener.stop.stop_requested()) return fail(kInterrupted);
    return report;
  });
}

Result<std::uint32_t> unpack(const UnpackOptions& options, const InspectListener& listener) {
  return without_exceptions([&]() -> Result<std::uint32_t> {
    const Result<Manifest> manifest = read_manifest(options.input);
    if (!manifest) return tl::unexpected(manifest.error());
    return unpack_parsed(options, *manifest, listener);
  });
}

}  // namespace pointreel
