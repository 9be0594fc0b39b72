#include "codec/segments/choose_cleaning.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "codec/segments/source_frames.h"

namespace pointreel {
namespace {

/// Evenly spread. Looking at one takes about as long as cleaning it.
constexpr std::size_t kLookedAt = 5;

/// Whether the noise of a frame is worth cleaning. Nothing if that is not what decides about it, or
/// if it cannot be read, which is reported when it is packed.
std::optional<bool> is_noisy(const CloudFrame& frame, const PackOptions& options) {
  auto read = read_cloud_frame(
      frame, {.max_memory = options.max_memory, .executor = options.encode.executor});
  if (!read) return std::nullopt;
  auto source = source_frame(std::move(*read), frame.name(), options);
  if (!source) return std::nullopt;
  const CleanReport report = clean_frame(source->cloud, options);
  if (report.cleaned) return true;
  return report.why == NotCleaned::smooth ? std::optional(false) : std::nullopt;
}

}  // namespace

void choose_cleaning(std::span<const CloudFrame> frames, PackOptions& options) {
  if (cleaning_of(options) == nullptr || options.clean->radius || options.clean->noisy ||
      frames.size() < 2)
    return;
  const std::size_t count = std::min(kLookedAt, frames.size());
  std::size_t noisy = 0, smooth = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = (2 * i + 1) * frames.size() / (2 * count);
    if (const auto found = is_noisy(frames[at], options)) ++(*found ? noisy : smooth);
  }
  if (noisy + smooth > 0) options.clean->noisy = noisy > smooth;
}

std::optional<bool> cleaning_choice(const PackOptions& options) {
  return options.clean ? options.clean->noisy : std::nullopt;
}

}  // namespace pointreel
