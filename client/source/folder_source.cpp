#include "client/source/folder_source.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "codec/core/scalar_fields.h"
#include "codec/files/cloud_file.h"
#include "common/base/natural_order.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

constexpr std::uint64_t kMaxFileBytes = std::uint64_t{4} << 30;
/// So many frames are looked at for the bounds of all, if the first has at most so many points.
constexpr std::size_t kLooks = 4, kQuickPoints = 1'000'000;

class FolderSource : public Source {
 public:
  FolderSource(std::vector<CloudFrame> files, Manifest manifest, const Placement& placement)
      : files_(std::move(files)), manifest_(std::move(manifest)), placement_(placement) {}

  const Manifest& manifest() const override { return manifest_; }

  Result<FetchedFrame> fetch(const FetchRequest& request) override {
    const CloudFrame& frame = files_[request.frame];
    CloudBytes bytes = TRY(fetch_cloud_frame(frame, kMaxFileBytes));
    FetchedFrame fetched;
    fetched.file = std::move(bytes.bytes);
    fetched.file_format = bytes.format;
    fetched.file_name = frame.name();
    fetched.reading = frame.reading;
    fetched.placement = placement_;
    return fetched;
  }

 private:
  const std::vector<CloudFrame> files_;
  const Manifest manifest_;
  const Placement placement_;
};

std::string name_of(const std::filesystem::path& path) {
  return path.filename().empty() ? path.parent_path().filename().string()
                                 : path.filename().string();
}

Result<std::unique_ptr<Source>> open_files(const std::vector<std::filesystem::path>& paths,
                                           std::string name, const SourceOptions& options) {
  CloudSequence sequence = TRY(
      list_cloud_frames(paths, {.topic = options.topic,
                                .max_memory = options.max_memory,
                                .reading = options.reading,
                                .stopped = [&options] { return options.stop.stop_requested(); }}));
  if (options.say) {
    for (const std::string& line : sequence.warnings) options.say("warning: " + line);
    for (const std::string& guess : sequence.guesses) options.say("read as " + guess);
  }
  std::vector<CloudFrame>& files = sequence.frames;
  const bool recorded = !sequence.times_us.empty() && !options.fps;
  Manifest manifest;
  manifest.name = std::move(name);
  manifest.codec = "files";
  manifest.fps = recorded ? std::clamp(sequence.fps, kMinFps, kMaxFps) : options.fps.value_or(30.0);
  const auto time_of = [&](std::size_t frame) {
    if (recorded) return frame < files.size() ? sequence.times_us[frame] : sequence.end_us();
    return static_cast<std::uint64_t>(
        std::llround(1e6 * static_cast<double>(frame) / manifest.fps));
  };
  manifest.duration_us = time_of(files.size());
  if (recorded) manifest.captured_us = sequence.captured_us();

  const auto read = [&](const CloudFrame& file) -> Result<LoadedCloud> {
    if (options.stop.stop_requested())
      return fail(ErrorCode::cancelled, file.name() + ": reading was cancelled");
    auto loaded = TRY(read_cloud_frame(file, {.max_memory = options.max_memory}));
    place(loaded.cloud, options.placement);
    return loaded;
  };
  std::optional<Error> first_error;
  bool found = false;
  std::size_t next = 0, points = 0;
  while (next < files.size() && points == 0) {
    const auto loaded = read(files[next++]);
    if (!loaded) {
      if (loaded.error().code == ErrorCode::cancelled) return tl::unexpected(loaded.error());
      if (!first_error) first_error = loaded.error();
      continue;
    }
    found = true;
    points = loaded->cloud.size();
    manifest.bounds = bounds(loaded->cloud);
    manifest.colors = loaded->cloud.has_colors();
    manifest.normals = loaded->cloud.has_normals();
    manifest.scalars = ranges_of(loaded->cloud);
  }
  if (!found) return tl::unexpected(*first_error);
  // Where the scene moves to, as far as that is seen in a moment.
  if (points > 0 && points <= kQuickPoints) {
    for (std::size_t i = 1; i <= kLooks; ++i) {
      const std::size_t at = i * (files.size() - 1) / kLooks;
      if (at < next) continue;
      next = at + 1;
      const auto loaded = read(files[at]);
      if (!loaded && loaded.error().code == ErrorCode::cancelled)
        return tl::unexpected(loaded.error());
      if (!loaded || loaded->cloud.empty()) continue;
      manifest.bounds.grow(bounds(loaded->cloud));
    }
  }
  // Who turns files means them to be upright then.
  if (options.placement.rotation == glm::dmat3(1.0))
    manifest.up = up_of_frame(files.front()).value_or(manifest.up);

  Segment segment;
  segment.cube = bounding_cube(manifest.bounds);
  for (std::size_t i = 0; i < files.size(); ++i) segment.times_us.push_back(time_of(i));
  segment.points.assign(files.size(), 0);
  manifest.segments.push_back(std::move(segment));
  return std::make_unique<FolderSource>(std::move(files), std::move(manifest), options.placement);
}

}  // namespace

Result<std::unique_ptr<Source>> open_folder_source(const std::filesystem::path& path,
                                                   const SourceOptions& options) {
  return open_files({path}, name_of(path), options);
}

Result<std::unique_ptr<Source>> open_file_sequence(std::vector<std::filesystem::path> files,
                                                   const SourceOptions& options) {
  std::sort(files.begin(), files.end(), [](const auto& a, const auto& b) {
    const std::string first = a.filename().string(), second = b.filename().string();
    return first == second ? a < b : natural_less(first, second);
  });
  std::string name = files.front().filename().string();
  if (files.size() > 1) name += fmt::format(" to {}", files.back().filename().string());
  return open_files(files, std::move(name), options);
}

}  // namespace pointreel
