#include "codec/segments/append_manifest.h"

#include <algorithm>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "codec/core/scalar_fields.h"
#include "codec/segments/cleaning.h"
#include "codec/segments/coding_error.h"

namespace pointreel {
namespace {

/// Why frames of the two cannot be in one reel; empty if they can.
std::string difference(const Manifest& a, const Manifest& b) {
  const auto differ = [](const char* what, const auto& one, const auto& other, const char* option) {
    return fmt::format("{}, {} and {} (set with pack {})", what, one, other, option);
  };
  if (a.codec != b.codec) return differ("codecs", a.codec, b.codec, "--codec");
  if (a.group_frames != b.group_frames)
    return differ("groups of frames", a.group_frames, b.group_frames, "--group");
  if (a.entropy != b.entropy) return differ("entropy coders", a.entropy, b.entropy, "--entropy");
  if (a.layer_names != b.layer_names) return "layers";
  if (a.up != b.up) return differ("up axes", a.up.text(), b.up.text(), "--up");
  const bool same_tables = a.tables.has_value() == b.tables.has_value() &&
                           (!a.tables || a.tables->checksum == b.tables->checksum);
  return same_tables ? "" : "context tables";
}

}  // namespace

Manifest manifest_before(const Manifest& part) {
  Manifest before;
  static_cast<ReelHead&>(before) = part;
  before.colors = before.normals = false;
  before.scalars.clear();
  before.captured_us = part.captured_us;
  before.tables = part.tables;
  return before;
}

Result<void> append_manifest(Manifest& whole, Manifest part) {
  if (const std::string what = difference(whole, part); !what.empty())
    return fail(ErrorCode::argument, "the two reels have different " + what);
  if (part.segments.empty()) return {};
  if (whole.segments.empty()) {
    whole.depth_min = part.depth_min;
    whole.depth_max = part.depth_max;
    whole.max_error = part.max_error;
  } else {
    whole.depth_min = std::min(whole.depth_min, part.depth_min);
    whole.depth_max = std::max(whole.depth_max, part.depth_max);
    // An error that nobody measured may be any.
    if (whole.max_error && part.max_error)
      *whole.max_error = std::max(*whole.max_error, *part.max_error);
    if (!part.max_error) whole.max_error.reset();
  }
  whole.bounds.grow(part.bounds);
  whole.colors |= part.colors;
  whole.normals |= part.normals;
  cover(whole.scalars, part.scalars);
  whole.partial |= part.partial;
  whole.normals_estimated |= part.normals_estimated;
  if (part.coding_error) add_coding_error(whole.coding_error, *part.coding_error);
  if (part.cleaning) {
    if (!whole.cleaning) whole.cleaning.emplace();
    add_cleaning(*whole.cleaning, *part.cleaning);
  }
  std::uint32_t next = whole.frame_count();
  for (Segment& segment : part.segments) {
    segment.first_frame = next;
    next += segment.frame_count();
    whole.segments.push_back(std::move(segment));
  }
  return {};
}

}  // namespace pointreel
