#include "codec/segments/input.h"

#include <algorithm>
#include <atomic>
#include <utility>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include "codec/package/cloud_memory.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

/// Frames that may stand in for one, on each side.
constexpr std::size_t kMostTried = 8;
constexpr std::size_t kKeepBytes = std::size_t{512} << 20;

/// The frame whose points reach farthest.
std::size_t widest(const std::vector<FrameExtent>& frames) {
  const auto reach = [](const FrameExtent& frame) {
    const glm::dvec3 farthest = glm::max(glm::abs(frame.box.min), glm::abs(frame.box.max));
    return frame.box.empty() ? 0.0 : std::max({farthest.x, farthest.y, farthest.z});
  };
  return std::ranges::max_element(frames, {}, reach) - frames.begin();
}

}  // namespace

std::string SegmentInput::name(std::size_t frame) const {
  return frames_ != nullptr ? frames_->name(first_ + frame)
                            : fmt::format("frame {}", first_ + frame);
}

Result<SourceFrame> SegmentInput::read(std::size_t frame) const {
  Result<SourceFrame> source = frames_->read(first_ + frame);
  if (source || !options_.best_effort) return source;
  std::string why = source.error().message;
  // The warning will begin with the name as well.
  if (const std::string begin = name(frame) + ": "; why.starts_with(begin))
    why.erase(0, begin.size());
  std::vector<std::size_t> others;
  for (std::size_t by = 1; by <= std::min(frame, kMostTried); ++by) others.push_back(frame - by);
  for (std::size_t by = 1; by <= kMostTried && frame + by < size(); ++by)
    others.push_back(frame + by);
  SourceFrame instead;
  std::string shown = "an empty frame";
  for (const std::size_t other : others) {
    Result<SourceFrame> readable = frames_->read(first_ + other);
    if (!readable) continue;
    instead = std::move(*readable);
    shown = name(other);
    break;
  }
  instead.unreadable = true;
  instead.warnings = {fmt::format("{}; {} is shown in its place", why, shown)};
  return instead;
}

Result<std::vector<FrameExtent>> SegmentInput::read_extents(const std::stop_token& stop) {
  std::vector<FrameExtent> frames(size());
  std::vector<std::optional<Error>> errors(size());
  std::vector<std::string> strays(size());
  std::atomic<std::size_t> kept_bytes = 0, next = 0;
  tbb::parallel_for(std::size_t{0}, size(), [&](std::size_t) {
    if (stop.stop_requested()) return;
    // In order, so that threads need the same frames around theirs.
    const std::size_t i = next++;
    Result<Cloud> loaded = look(i);
    if (!loaded) {
      errors[i] = std::move(loaded.error());
      return;
    }
    const Cloud& source = *loaded;
    strays[i] = source->strays;
    frames[i] = extent_of(source->cloud, source->cleaning);
    const std::size_t bytes = memory_of(source->cloud);
    if (kept_bytes.fetch_add(bytes) + bytes <= kKeepBytes) kept_[i] = source;
  });
  for (const auto& error : errors) {
    if (error) return tl::unexpected(*error);
  }
  const auto first = std::ranges::find_if(strays, [](const auto& text) { return !text.empty(); });
  if (first != strays.end()) strays_ = std::move(*first);
  return frames;
}

Result<void> SegmentInput::find_shared_grid(const std::stop_token& stop) {
  if (options_.cube_per_frame) return {};
  const std::vector<FrameExtent> extents = TRY(read_extents(stop));
  std::optional<Error> unread;
  const auto cloud_of = [&](std::size_t frame) -> Result<std::shared_ptr<const PointCloud>> {
    const Result<Cloud> read = look(frame);
    if (read) return std::shared_ptr<const PointCloud>(*read, &(*read)->cloud);
    unread = read.error();
    return tl::unexpected(*unread);
  };
  const Result<Grid> grid = grid_for_frames(extents, options_, cloud_of);
  if (unread) return tl::unexpected(*unread);
  if (!grid && !strays_.empty())
    return fail(ErrorCode::limit, fmt::format("{} ({})", strays_, grid.error().message));
  if (!grid) return fail_at(name(widest(extents)), grid.error());
  shared_ = *grid;
  return {};
}

Result<Grid> SegmentInput::grid_of(const SourceFrame& frame) const {
  if (shared_) return *shared_;
  const PointCloud& cloud = frame.cloud;
  const Box box = bounds(cloud);
  if (frame.cleaning.cleaned && cells_follow_points(options_)) {
    return grid_for(box, options_, lattice_for_cells(frame.cleaning.cell));
  }
  std::optional<PointLattice> lattice = lattice_of(cloud);
  if (lattice && !options_.voxel && !reaches(*lattice, box, cloud, options_.encode)) {
    lattice.reset();
  }
  return grid_for(box, options_, lattice);
}

Result<SegmentInput::Cloud> SegmentInput::look(std::size_t frame) const {
  if (kept_[frame] != nullptr) return kept_[frame];
  return std::make_shared<const SourceFrame>(TRY(read(frame)));
}

Result<SegmentInput::Cloud> SegmentInput::take(std::size_t frame) {
  Result<Cloud> cloud = look(frame);
  if (frames_ != nullptr) kept_[frame].reset();
  return cloud;
}

}  // namespace pointreel
