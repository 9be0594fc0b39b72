#include "codec/segments/source_frames.h"

#include <algorithm>
#include <list>
#include <mutex>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include "codec/core/keep_points.h"
#include "codec/octree/frame_header.h"
#include "codec/package/strays.h"
#include "codec/segments/missing_normals.h"
#include "codec/surface/normals.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

bool is_same(const CloudFrame& a, const CloudFrame& b) {
  return a.file == b.file && a.index == b.index;
}

}  // namespace

Result<SourceFrame> source_frame(LoadedCloud loaded, const std::string& name,
                                 const PackOptions& options) {
  SourceFrame source;
  static_cast<LoadedCloud&>(source) = std::move(loaded);
  if (const std::vector<std::size_t> strays = find_strays(source.cloud); !strays.empty()) {
    const std::string text = strays_text(source.cloud, strays, source.left_out == 0);
    if (options.best_effort) {
      source.left_out += keep_points(source.cloud, [&](std::size_t i) {
        return !std::binary_search(strays.begin(), strays.end(), i);
      });
      source.warnings.push_back(
          fmt::format("{}, and {} left out", text, strays.size() == 1 ? "is" : "are"));
    } else {
      const std::string advice = "remove such points, or let --best-effort leave them out";
      source.strays = fmt::format("{}: {}: {}", name, text, advice);
      source.warnings.push_back(fmt::format("{}, so voxels may be larger: {}", text, advice));
    }
  }
  place(source.cloud, options.placement);
  const Box box = bounds(source.cloud);
  if (const glm::dvec3 extent = box.extent(); std::max({extent.x, extent.y, extent.z}) > 1.0) {
    const auto codable = check_codable(bounding_cube(box));
    if (!codable && !source.strays.empty())
      return fail(ErrorCode::limit, fmt::format("{} ({})", source.strays, codable.error().message));
    if (!codable)
      return fail(ErrorCode::invalid, fmt::format("{}: {}", name, codable.error().message));
  }
  return source;
}

void add_missing_normals(SourceFrame& source, const PackOptions& options) {
  const bool estimates =
      options.missing_normals == MissingNormals::estimated && encodes_normals(options);
  if (!estimates || source.cloud.empty() || source.cloud.has_normals()) return;
  estimate_normals(source.cloud, options.encode.executor);
  source.normals_estimated = true;
}

/// A frame that was cleaned by itself.
struct SourceFrames::Alone {
  SourceFrame frame;  ///< but for its cloud
  CleanedFrame cleaned;
};

/// The frames that were asked for last. Each is made once while it is kept.
class SourceFrames::Recent {
 public:
  using Made = Result<std::shared_ptr<const Alone>>;

  explicit Recent(std::size_t most) : most_(most) {}

  template <class Make>
  Made get(std::size_t frame, const Make& make) {
    const std::shared_ptr<Entry> entry = find(frame);
    const std::lock_guard lock(entry->mutex);
    if (!entry->made) entry->made = make();
    return *entry->made;
  }

 private:
  struct Entry {
    std::size_t frame;
    std::mutex mutex;
    std::optional<Made> made;
  };

  /// The entry becomes the first.
  std::shared_ptr<Entry> find(std::size_t frame) {
    const std::lock_guard lock(mutex_);
    const auto found = std::find_if(entries_.begin(), entries_.end(),
                                    [&](const auto& entry) { return entry->frame == frame; });
    if (found == entries_.end()) {
      entries_.push_front(std::make_shared<Entry>());
      entries_.front()->frame = frame;
      if (entries_.size() > most_) entries_.pop_back();
    } else {
      entries_.splice(entries_.begin(), entries_, found);
    }
    return entries_.front();
  }

  const std::size_t most_;
  std::mutex mutex_;
  std::list<std::shared_ptr<Entry>> entries_;  ///< the last that was asked for first
};

SourceFrames::SourceFrames(std::span<const CloudFrame> sequence, const PackOptions& options)
    : sequence_(sequence),
      options_(options),
      // Those around one frame, and one more for each thread that is ahead.
      recent_(std::make_unique<Recent>(
          2 * options.clean_frames + 1 +
          static_cast<std::size_t>(tbb::this_task_arena::max_concurrency()))) {}

SourceFrames::~SourceFrames() = default;

Result<SourceFrame> SourceFrames::read(std::size_t frame) const {
  SourceFrame source = TRY(read_cleaned(frame));
  add_missing_normals(source, options_);
  return source;
}

Result<SourceFrame> SourceFrames::read_cleaned(std::size_t frame) const {
  if (options_.clean_frames == 0 || cleaning_of(options_) == nullptr) {
    SourceFrame source = TRY(load(frame));
    source.cleaning = clean_frame(source.cloud, options_);
    return source;
  }
  const std::shared_ptr<const Alone> own = TRY(alone(frame));
  std::vector<std::shared_ptr<const Alone>> others;
  std::vector<const CleanedFrame*> cleaned;
  if (own->cleaned.report.cleaned) {
    for (const std::size_t other : around(frame)) {
      // One that cannot be read is no error of this frame.
      Recent::Made made = alone(other);
      if (!made) continue;
      cleaned.push_back(&(*made)->cleaned);
      others.push_back(std::move(*made));
    }
  }
  CleanedInTime in_time = clean_frame(own->cleaned, cleaned, options_);
  SourceFrame source = own->frame;
  source.cloud = std::move(in_time.cloud);
  source.cleaning = in_time.report;
  return source;
}

/// Those on either side that are other frames: where some are missing, one may stand there again.
std::vector<std::size_t> SourceFrames::around(std::size_t frame) const {
  std::vector<std::size_t> found{frame};
  const std::size_t reach = options_.clean_frames;
  for (std::size_t other = frame - std::min(frame, reach);
       other < std::min(frame + reach + 1, sequence_.size()); ++other) {
    const bool known = std::any_of(found.begin(), found.end(), [&](std::size_t one) {
      return is_same(sequence_[one], sequence_[other]);
    });
    if (!known) found.push_back(other);
  }
  found.erase(found.begin());
  return found;
}

Result<std::shared_ptr<const SourceFrames::Alone>> SourceFrames::alone(std::size_t frame) const {
  return recent_->get(frame, [&]() -> Recent::Made {
    SourceFrame source = TRY(load(frame));
    Alone made;
    made.cleaned =
        clean_alone(std::move(source.cloud), *cleaning_of(options_), options_.encode.executor);
    source.cloud = {};
    made.frame = std::move(source);
    return std::make_shared<const Alone>(std::move(made));
  });
}

Result<SourceFrame> SourceFrames::load(std::size_t frame) const {
  return source_frame(
      TRY(read_cloud_frame(sequence_[frame], {.max_memory = options_.max_memory,
                                              .executor = options_.encode.executor})),
      name(frame), options_);
}

}  // namespace pointreel
