#include <algorithm>
#include <mutex>
#include <optional>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "common/base/natural_order.h"
#include "common/base/output_folder.h"
#include "common/base/try.h"
#include "common/base/words.h"
#include "common/cloud/ply.h"
#include "common/stream/manifest.h"
#include "server/pack/inspect.h"
#include "server/pack/read_package.h"

namespace pointreel {
namespace fs = std::filesystem;
namespace {

/// The least number of digits in the name of an unpacked frame.
constexpr std::size_t kDigits = 5;

/// With --force, folders of unpacked frames are replaced, but nothing else.
Result<void> may_replace_frames(const fs::path& folder) {
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (!is_numbered(name, "frame_", kDigits, ".ply")) {
      return fail(ErrorCode::argument,
                  fmt::format("holds {}, and --force replaces only folders of unpacked frames; "
                              "remove it first",
                              name));
    }
  }
  if (error) return fail(ErrorCode::io, error.message());
  return {};
}

Result<void> unpack_frame(const UnpackOptions& options, const Manifest& manifest,
                          const FrameDecoder& decoder, std::uint32_t frame, const fs::path& path) {
  const auto layers = TRY(read_frame(options.input, manifest, frame, options.layers));
  const Result<DecodedFrame> decoded = decoder.decode(layer_views(layers));
  if (!decoded) {
    return fail_at(fmt::format("{}: frame {}", options.input.string(), frame), decoded.error());
  }
  return write_ply(path, decoded->cloud);
}

Result<std::uint32_t> unpack_parsed(const UnpackOptions& options, const Manifest& manifest,
                                    const InspectListener& listener) {
  const std::uint32_t frames = manifest.frame_count();
  const bool past_the_end = options.last_frame != kToTheEnd && options.last_frame >= frames;
  if (options.layers == 0 || options.first_frame > options.last_frame || past_the_end ||
      (options.first_frame >= frames && frames > 0)) {
    return fail(ErrorCode::argument,
                fmt::format("{}: has {}, numbered from 0, and {}; ask for at least "
                            "one of each",
                            options.input.string(), counted(frames, "frame"),
                            counted(manifest.layer_names.size(), "layer")));
  }
  FrameDecoder decoder(options.max_memory);
  if (manifest.tables) {
    const auto read = decoder.read_tables(options.input, *manifest.tables);
    if (!read) return fail_at((options.input / manifest.tables->path).string(), read.error());
  }
  OutputFolder folder = TRY(OutputFolder::create(
      options.output, options.force ? may_replace_frames : OutputFolder::MayReplace{}));

  const std::uint32_t last = std::min<std::uint32_t>(options.last_frame, frames - 1);
  const std::uint32_t count = frames == 0 ? 0 : last - options.first_frame + 1;
  const std::size_t digits = std::max<std::size_t>(kDigits, fmt::format("{}", last).size());
  if (listener.begin) listener.begin(count);
  std::mutex mutex;
  std::optional<std::pair<std::uint32_t, Error>> first_error;
  for_each_frame(count, listener, [&](std::uint32_t i) {
    const std::uint32_t frame = options.first_frame + i;
    const fs::path path = folder.path() / fmt::format("frame_{:0{}}.ply", frame, digits);
    if (const Result<void> done = unpack_frame(options, manifest, decoder, frame, path); !done) {
      const std::lock_guard lock(mutex);
      if (!first_error || frame < first_error->first) first_error = {frame, done.error()};
    }
  });
  if (first_error) return tl::unexpected(first_error->second);
  if (listener.stop.stop_requested()) return fail(ErrorCode::cancelled, kInterrupted);
  TRY(folder.publish());
  return count;
}

}  // namespace

Result<std::uint32_t> unpack(const UnpackOptions& options, const InspectListener& listener) {
  return without_exceptions([&]() -> Result<std::uint32_t> {
    return unpack_parsed(options, TRY(read_manifest(options.input)), listener);
  });
}

}  // namespace pointreel
