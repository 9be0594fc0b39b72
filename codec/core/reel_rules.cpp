#include "codec/core/reel_rules.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "codec/core/json_fields.h"
#include "common/base/concat.h"
#include "common/base/try.h"
#include "pointreel/cloud.h"
#include "pointreel/octree.h"

namespace pointreel {
namespace {

constexpr std::uint64_t kMaxFrames = 0xffffffffu;

bool is_finite(const glm::dvec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

Result<void> check_layer_names(const std::vector<std::string>& names) {
  if (names.empty() || names.size() > kMaxLayers) {
    return fail(concat("layers: has ", names.size(), " names, not 1 to ", kMaxLayers));
  }
  for (auto name = names.begin(); name != names.end(); ++name) {
    if (!is_file_name(*name) || name->size() > kMaxLayerName) {
      return fail(concat("layers: a name may have only letters, digits, '.', '_' and '-', at most ",
                         kMaxLayerName));
    }
    if (std::find(names.begin(), name, *name) != name) {
      return fail(concat("layers: \"", *name, "\" comes twice"));
    }
  }
  return {};
}

Result<void> check_scalar_ranges(const std::vector<ScalarRange>& scalars) {
  if (scalars.size() > kMaxScalars)
    return fail(concat("scalars: has more than ", kMaxScalars, " fields"));
  for (auto field = scalars.begin(); field != scalars.end(); ++field) {
    if (!is_scalar_name(field->name)) {
      return fail(concat("scalars: a name is not 1 to ", kMaxScalarName,
                         " bytes of text that may be shown"));
    }
    const auto same = [&](const ScalarRange& other) { return other.name == field->name; };
    if (std::find_if(scalars.begin(), field, same) != field)
      return fail(concat("scalars: \"", field->name, "\" comes twice"));
    if (!std::isfinite(field->least) || !std::isfinite(field->most) || field->least > field->most)
      return fail(concat("scalars: \"", field->name, "\" has no finite range"));
  }
  return {};
}

Result<void> check_file(const PackageFile& file, std::uint64_t max_bytes) {
  if (!is_file_name(file.path)) return fail("path: is not a plain file name");
  if (file.bytes > max_bytes) return fail(concat("bytes: is above ", max_bytes));
  return {};
}

Result<void> check_times(const Segment& segment, std::uint64_t last_time) {
  if (segment.times_us.empty()) {
    return fail("times_us: is empty, but a segment has at least one frame");
  }
  if (segment.points.size() != segment.times_us.size()) {
    return fail(concat("points: ", segment.points.size(), " entries for ", segment.times_us.size(),
                       " frames"));
  }
  for (std::size_t i = 0; i < segment.times_us.size(); ++i) {
    const std::uint64_t time = segment.times_us[i];
    if (time < last_time) {
      return fail(concat("times_us[", i, "]: ", time, " comes after ", last_time));
    }
    last_time = time;
  }
  return {};
}

Result<void> check_layer_file(const LayerFile& file, const Segment& segment) {
  TRY(check_file(file, kMaxInteger));
  if (file.frames.size() != segment.frame_count()) {
    return fail(
        concat("frames: ", file.frames.size(), " entries for ", segment.frame_count(), " frames"));
  }
  std::uint64_t sum = 0;
  for (const Chunks<std::uint32_t>& sizes : file.frames) sum += total(sizes);
  if (sum != file.bytes) {
    return fail(concat("bytes: ", file.bytes, ", but its frames take ", sum));
  }
  return {};
}

/// `first`: the number of frames before. `last_time`: the time of the frame before.
Result<void> check_segment(const Segment& segment, const ReelHead& head, std::uint64_t first,
                           std::uint64_t last_time) {
  if (segment.first_frame != first) {
    return fail(concat("first_frame: ", segment.first_frame, ", but frames are consecutive and ",
                       first, " comes next"));
  }
  TRY(at_place("cube", check_cube(segment.cube)));
  TRY(check_times(segment, last_time));
  if (segment.layers.size() != head.layer_names.size()) {
    return fail(concat("files: ", segment.layers.size(), " entries for ", head.layer_names.size(),
                       " layers"));
  }
  for (std::size_t i = 0; i < segment.layers.size(); ++i) {
    const std::string place = concat("files[", i, "]");
    const LayerFile& file = segment.layers[i];
    TRY(at_place(place, check_layer_file(file, segment)));
    for (std::size_t k = 0; k < file.frames.size(); ++k) {
      const bool refines = i == 0 || segment.layers[i - 1].frames[k].geometry > 0;
      if (const auto right = check_chunks(head, i, file.frames[k], refines); !right) {
        return fail_at(concat(place, ".frames[", k, "]"), right.error());
      }
    }
  }
  return {};
}

Result<void> check_group(const ReelHead& head) {
  if (head.codec != "video") {
    if (head.group_frames != 0) return fail("group_frames: is given, but only video has groups");
    return {};
  }
  if (head.group_frames < 1 || head.group_frames > kMostGroupFrames)
    return fail(concat("group_frames: is not from 1 to ", kMostGroupFrames));
  if (head.layer_names.size() != 2) return fail("layers: video has two");
  if (!head.scalars.empty()) return fail("scalars: video has none");
  return {};
}

}  // namespace

Result<void> check_head(const ReelHead& head) {
  if (!is_title(head.name)) {
    return fail(concat("name: has more than ", kMaxTitle,
                       " bytes, or a character that must not be shown: a control character, or one "
                       "that turns the direction of writing"));
  }
  if (head.codec == "octree" || head.codec == "video") {
    if (head.entropy != "none" && head.entropy != "zstd" && head.entropy != "context") {
      return fail("entropy: is not \"none\", \"zstd\" or \"context\"");
    }
  } else if (head.codec != "draco") {
    return fail("codec: is not \"octree\", \"draco\" or \"video\"");
  } else if (!head.entropy.empty()) {
    return fail("entropy: is given, but this codec has none");
  }
  if (!is_frame_rate(head.fps)) return fail("fps: is not a number from 0.000001 to 1000000");
  TRY(check_scalar_ranges(head.scalars));
  TRY(check_layer_names(head.layer_names));
  return check_group(head);
}

Result<void> check_box(const Box& box) {
  const Box nothing;
  if (box == nothing) return {};
  if (!is_finite(box.min)) return fail("min: is not three finite numbers");
  if (!is_finite(box.max)) return fail("max: is not three finite numbers");
  if (!glm::all(glm::lessThanEqual(box.min, box.max))) return fail("min is beyond max");
  if (!is_finite(box.max - box.min)) return fail("max: is too far from min");
  return {};
}

Result<void> check_cube(const Cube& cube) {
  if (!is_finite(cube.origin)) return fail("origin: is not three finite numbers");
  if (!(cube.edge > 0.0) || !is_finite(cube.origin + cube.edge) || !std::isfinite(cube.edge)) {
    return fail("edge: is not a finite number above 0, or the far corner is not finite");
  }
  return {};
}

Result<void> check_chunks(const ReelHead& head, std::size_t layer,
                          const Chunks<std::uint32_t>& sizes, bool refines) {
  if (sizes.geometry == 0 && (layer == 0 || total(sizes) > 0)) return fail("has no geometry");
  if (sizes.geometry > 0 && !refines) return fail("refines a layer that the frame does not have");
  if (sizes.colors > 0 && !head.colors) return fail("has colours in a reel without colours");
  if (sizes.normals > 0 && !head.normals) return fail("has normals in a reel without normals");
  return {};
}

Result<void> check_not_negative(std::initializer_list<std::pair<const char*, double>> members) {
  for (const auto& [name, value] : members) {
    if (!(value >= 0.0 && std::isfinite(value)))
      return fail(concat(name, ": is not a finite number from 0 on"));
  }
  return {};
}

Result<void> check_cleaning(const Cleaning& cleaning) {
  if (cleaning.removed > kMaxInteger) return fail("removed_points: is above 2^53 - 1");
  return check_not_negative(
      {{"spacing", cleaning.spacing}, {"noise", cleaning.noise}, {"radius", cleaning.radius}});
}

Result<void> check_coding_error(const CodingError& error) {
  if (error.frames == 0) return fail("frames: is 0");
  return check_not_negative(
      {{"d1", error.d1}, {"d2", error.d2.value_or(0.0)}, {"luma", error.luma.value_or(0.0)}});
}

Result<void> check_manifest(const Manifest& manifest) {
  TRY(check_head(manifest));
  if (manifest.duration_us > kMaxInteger) return fail("duration_us: is above 2^53 - 1");
  if (manifest.depth_max > kMaxDepth) return fail(concat("depth_max: is above ", kMaxDepth));
  if (manifest.depth_min > manifest.depth_max) return fail("depth_min: is above depth_max");
  TRY(at_place("bounds", check_box(manifest.bounds)));
  TRY(check_not_negative({{"max_error", manifest.max_error.value_or(0.0)}}));
  if (manifest.coding_error) {
    TRY(at_place("coding_error", check_coding_error(*manifest.coding_error)));
    if (manifest.coding_error->frames > manifest.frame_count())
      return fail("coding_error: frames: are more than the reel has");
  }
  if (manifest.cleaning) TRY(at_place("cleaning", check_cleaning(*manifest.cleaning)));
  std::set<std::string_view> paths;
  if (manifest.tables) {
    if (manifest.entropy != "context") return fail("tables: belong to entropy \"context\" alone");
    TRY(at_place("tables", check_file(*manifest.tables, kMaxTablesBytes)));
    paths.insert(manifest.tables->path);
  }
  if (manifest.audio) {
    TRY(at_place("audio", check_file(*manifest.audio, kMaxAudioBytes)));
    if (manifest.audio->samples == 0 || manifest.audio->samples > kMaxInteger) {
      return fail("audio: samples: is not from 1 to 2^53 - 1");
    }
    if (!paths.insert(manifest.audio->path).second) {
      return fail(concat("audio: \"", manifest.audio->path, "\" is used twice"));
    }
  }
  if (manifest.captured_us && *manifest.captured_us > kMaxInteger) {
    return fail("captured_us: is above 2^53 - 1");
  }
  if (manifest.live && manifest.live->start_us > kMaxInteger) {
    return fail("live: start_us: is above 2^53 - 1");
  }
  std::uint64_t frames = 0, last_time = 0;
  bool any_point = false;
  for (std::size_t i = 0; i < manifest.segments.size(); ++i) {
    const std::string place = concat("segments[", i, "]");
    const Segment& segment = manifest.segments[i];
    TRY(at_place(place, check_segment(segment, manifest, frames, last_time)));
    frames += segment.frame_count();
    if (frames > kMaxFrames) {
      return fail_at(place, {"a reel has fewer than 2^32 frames", ErrorCode::limit});
    }
    if (segment.sound) {
      const std::string of_sound = concat(place, ".sound");
      if (!manifest.live) return fail_at(of_sound, {"belongs to live streams alone"});
      TRY(at_place(of_sound, check_file(*segment.sound, kMaxSegmentSoundBytes)));
    }
    for (const PackageFile* file : segment.files()) {
      if (!paths.insert(file->path).second) {
        return fail_at(place, {concat("\"", file->path, "\" is used twice")});
      }
    }
    last_time = segment.times_us.back();
    any_point = any_point || std::ranges::any_of(segment.points, [](auto n) { return n > 0; });
  }
  if (manifest.duration_us < last_time) {
    return fail(concat("duration_us: ", manifest.duration_us, ", but the last frame is shown at ",
                       last_time));
  }
  if (any_point == manifest.bounds.empty()) {
    return fail("bounds: must be a box if any frame has a point, otherwise null");
  }
  return {};
}

}  // namespace pointreel
