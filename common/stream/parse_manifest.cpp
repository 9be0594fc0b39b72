#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "common/base/concat.h"
#include "common/base/try.h"
#include "common/stream/json_fields.h"
#include "pointreel/octree.h"
#include "pointreel/package.h"

namespace pointreel {
namespace {

constexpr std::uint64_t kMaxUint32 = 0xffffffffu;

std::optional<std::uint32_t> uint32_of(const JsonValue& value) {
  const std::optional<std::uint64_t> number = value.integer();
  if (!number || *number > kMaxUint32) return std::nullopt;
  return static_cast<std::uint32_t>(*number);
}

/// Three whole numbers, the sizes of a frame's chunks in one layer.
std::optional<Chunks<std::uint32_t>> sizes_of(const JsonValue& value) {
  if (!value.is_array()) return std::nullopt;
  std::array<std::uint32_t, 3> sizes{};
  std::size_t n = 0;
  for (JsonItems item(value); item.next(); ++n) {
    const std::optional<std::uint32_t> size = uint32_of(item.value());
    if (!size || n == sizes.size()) return std::nullopt;
    sizes[n] = *size;
  }
  if (n != sizes.size()) return std::nullopt;
  return Chunks<std::uint32_t>{sizes[0], sizes[1], sizes[2]};
}

/// Parses the members that all files have.
Result<PackageFile> parse_file(const JsonValue& object, std::uint64_t max_bytes) {
  Fields fields(object);
  PackageFile file;
  file.path = fields.text("path");
  file.bytes = fields.integer("bytes", max_bytes);
  const std::string checksum = fields.text("xxh3");
  TRY(fields.check());

  if (!is_file_name(file.path)) return fail("path: is not a plain file name");
  const std::optional<std::uint64_t> value = parse_hex(checksum);
  if (!value) return fail("xxh3: is not 16 lowercase hexadecimal digits");
  file.checksum = *value;
  return file;
}

Result<LayerFile> parse_layer(const JsonValue& object, std::uint32_t frame_count) {
  LayerFile file{TRY(parse_file(object, kMaxInteger)), {}};
  Fields fields(object);
  const JsonValue frames = fields.array("frames");
  TRY(fields.check());
  const std::size_t count = frames.size();
  if (count != frame_count) {
    return fail(concat("frames: ", count, " entries for ", frame_count, " frames"));
  }
  file.frames.reserve(count);
  std::uint64_t sum = 0;
  for (JsonItems item(frames); item.next();) {
    const auto sizes = sizes_of(item.value());
    if (!sizes) {
      return fail(concat("frames[", file.frames.size(), "]: is not three whole numbers from 0 to ",
                         kMaxUint32));
    }
    file.frames.push_back(*sizes);
    sum += total(*sizes);
  }
  if (sum != file.bytes) {
    return fail(concat("bytes: ", file.bytes, ", but its frames take ", sum));
  }
  return file;
}

/// Checks that each frame has geometry in its base layer and in every layer where it has anything,
/// that none of its layers refines a missing one, and that it has no attribute that the reel lacks.
Result<void> check_chunks(const Manifest& manifest, const Segment& segment) {
  for (std::size_t layer = 0; layer < segment.layers.size(); ++layer) {
    for (std::uint32_t i = 0; i < segment.frame_count(); ++i) {
      const Chunks<std::uint32_t>& sizes = segment.layers[layer].frames[i];
      const char* fault = nullptr;
      if (sizes.geometry == 0 && (layer == 0 || total(sizes) > 0)) {
        fault = "has no geometry";
      } else if (layer > 0 && sizes.geometry > 0 &&
                 segment.layers[layer - 1].frames[i].geometry == 0) {
        fault = "refines a layer that the frame does not have";
      } else if (sizes.colors > 0 && !manifest.colors) {
        fault = "has colours in a reel without colours";
      } else if (sizes.normals > 0 && !manifest.normals) {
        fault = "has normals in a reel without normals";
      }
      if (fault != nullptr) return fail(concat("files[", layer, "].frames[", i, "]: ", fault));
    }
  }
  return {};
}

/// Parses the times and numbers of points of a segment's frames. `last_time`: the time of the frame
/// before.
Result<void> parse_frames(const JsonValue& times, const JsonValue& points, std::uint64_t last_time,
                          Segment& segment) {
  const std::size_t frames = times.size(), counts = points.size();
  if (frames == 0) return fail("times_us: is empty, but a segment has at least one frame");
  if (counts != frames) {
    return fail(concat("points: ", counts, " entries for ", frames, " frames"));
  }
  segment.times_us.reserve(frames);
  for (JsonItems item(times); item.next();) {
    const std::optional<std::uint64_t> time = item.value().integer();
    if (!time || *time > kMaxInteger) {
      return fail(concat("times_us[", segment.times_us.size(),
                         "]: is not a whole number from 0 to ", kMaxInteger));
    }
    if (*time < last_time) {
      return fail(
          concat("times_us[", segment.times_us.size(), "]: ", *time, " comes after ", last_time));
    }
    last_time = *time;
    segment.times_us.push_back(last_time);
  }
  segment.points.reserve(frames);
  for (JsonItems item(points); item.next();) {
    const std::optional<std::uint32_t> count = uint32_of(item.value());
    if (!count) {
      return fail(concat("points[", segment.points.size(), "]: is not a whole number from 0 to ",
                         kMaxUint32));
    }
    segment.points.push_back(*count);
  }
  return {};
}

Result<Cube> parse_cube(const JsonValue& object) {
  Fields fields(object);
  const Cube cube{fields.vector("origin"), fields.number("edge")};
  TRY(fields.check());
  const glm::dvec3 far = cube.origin + cube.edge;
  if (!(cube.edge > 0.0) || !std::isfinite(far.x + far.y + far.z)) {
    return fail("edge: is not a finite number above 0");
  }
  return cube;
}

/// `manifest` already holds everything but the segments, and the segments before this one.
Result<Segment> parse_segment(const JsonValue& object, const Manifest& manifest,
                              std::uint32_t first, std::uint64_t last_time) {
  Fields fields(object);
  Segment segment;
  segment.first_frame = static_cast<std::uint32_t>(fields.integer("first_frame", kMaxUint32));
  const JsonValue* cube_value = fields.value("cube");
  const JsonValue times = fields.array("times_us");
  const JsonValue points = fields.array("points");
  const JsonValue files = fields.array("files");
  TRY(fields.check());

  if (segment.first_frame != first) {
    return fail(concat("first_frame: ", segment.first_frame, ", but frames are consecutive and ",
                       first, " comes next"));
  }
  segment.cube = TRY(at_place("cube", parse_cube(*cube_value)));
  TRY(parse_frames(times, points, last_time, segment));
  const std::size_t count = files.size();
  if (count != manifest.layer_names.size()) {
    return fail(concat("files: ", count, " entries for ", manifest.layer_names.size(), " layers"));
  }
  for (JsonItems item(files); item.next();) {
    const std::string place = concat("files[", segment.layers.size(), "]");
    segment.layers.push_back(
        TRY(at_place(place, parse_layer(item.value(), segment.frame_count()))));
  }
  TRY(check_chunks(manifest, segment));
  return segment;
}

Result<void> parse_segments(const JsonValue& entries, Manifest& manifest) {
  std::uint64_t frames = 0, last_time = 0;
  std::set<std::string> paths;
  if (manifest.tables) paths.insert(manifest.tables->path);
  bool any_point = false;
  for (JsonItems item(entries); item.next();) {
    const std::string place = concat("segments[", manifest.segments.size(), "]");
    const auto first = static_cast<std::uint32_t>(frames);
    Segment segment = TRY(at_place(place, parse_segment(item.value(), manifest, first, last_time)));
    frames += segment.frame_count();
    if (frames > kMaxUint32)
      return fail_at(place, {"a reel has fewer than 2^32 frames", ErrorCode::limit});
    for (const LayerFile& file : segment.layers) {
      if (!paths.insert(file.path).second) {
        return fail_at(place, {concat("\"", file.path, "\" is used twice")});
      }
    }
    last_time = segment.times_us.back();
    for (const std::uint32_t count : segment.points) any_point = any_point || count > 0;
    manifest.segments.push_back(std::move(segment));
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

Result<LiveManifest> parse_live(const JsonValue& object) {
  Fields fields(object);
  LiveManifest live;
  const std::optional<std::uint64_t> session = parse_hex(fields.text("session"));
  if (!session) fields.refuse("session", "is not 16 lowercase hexadecimal digits");
  live.first_frame = static_cast<std::uint32_t>(fields.integer("first_frame", kMaxUint32));
  live.start_us = fields.integer("start_us", kMaxInteger);
  live.ended = fields.boolean("ended");
  TRY(fields.check());
  live.session = *session;
  return live;
}

/// Checks the members that say whether the others can be understood.
Result<void> check_format(const JsonValue& root) {
  Fields fields(root);
  const std::string format = fields.text("format");
  const std::uint64_t version = fields.integer("version", kMaxInteger);
  TRY(fields.check());
  if (format != kPackageFormat) return fail(concat("format: is not \"", kPackageFormat, "\""));
  if (version > kPackageVersion) {
    return fail(ErrorCode::unsupported,
                concat("format version ", version, " is newer than ", kPackageVersion,
                       ", the newest that this program reads: update it"));
  }
  if (version != kPackageVersion) {
    return fail(concat("format version ", version, " does not exist"));
  }
  return {};
}

Result<Manifest> parse_root(const JsonValue& root) {
  TRY(check_format(root));
  Fields fields(root);
  Manifest manifest;
  read_reel_head(fields, manifest);
  manifest.duration_us = fields.integer("duration_us", kMaxInteger);
  manifest.depth_min = static_cast<std::uint32_t>(fields.integer("depth_min", kMaxDepth));
  manifest.depth_max = static_cast<std::uint32_t>(fields.integer("depth_max", kMaxDepth));
  const JsonValue* bounds = fields.value("bounds");
  const JsonValue segments = fields.array("segments");
  if (manifest.depth_min > manifest.depth_max) fields.refuse("depth_min", "is above depth_max");
  TRY(fields.check());
  manifest.bounds = TRY(at_place("bounds", parse_box(*bounds)));
  if (fields.has("max_error")) {
    manifest.max_error = fields.number("max_error");
    if (*manifest.max_error < 0.0) fields.refuse("max_error", "is negative");
    TRY(fields.check());
  }
  if (fields.has("tables")) {
    if (manifest.entropy != "context") return fail("tables: belong to entropy \"context\" alone");
    manifest.tables = TRY(at_place("tables", parse_file(*fields.value("tables"), kMaxTablesBytes)));
  }
  if (fields.has("partial")) manifest.partial = fields.boolean("partial");
  if (fields.has("live")) {
    manifest.live = TRY(at_place("live", parse_live(*fields.value("live"))));
  }
  TRY(parse_segments(segments, manifest));
  return manifest;
}

}  // namespace

Result<Manifest> parse_manifest(std::string_view text) {
  if (text.size() > kMaxManifestBytes) {
    return fail(ErrorCode::limit, concat("is longer than ", kMaxManifestBytes, " bytes"));
  }
  return parse_root(TRY(parse_json(text)));
}

}  // namespace pointreel
