#include <array>
#include <optional>
#include <utility>

#include "codec/core/json_fields.h"
#include "codec/core/reel_rules.h"
#include "common/base/concat.h"
#include "common/base/out_of_memory.h"
#include "common/base/try.h"
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
Result<PackageFile> parse_file(const JsonValue& object) {
  Fields fields(object);
  PackageFile file;
  file.path = fields.text("path");
  file.bytes = fields.integer("bytes", kMaxInteger);
  const std::string checksum = fields.text("xxh3");
  TRY(fields.check());
  const std::optional<std::uint64_t> value = parse_hex(checksum);
  if (!value) return fail("xxh3: is not 16 lowercase hexadecimal digits");
  file.checksum = *value;
  return file;
}

Result<AudioFile> parse_audio(const JsonValue& object) {
  AudioFile audio{TRY(parse_file(object)), 0};
  Fields fields(object);
  audio.samples = fields.integer("samples", kMaxInteger);
  TRY(fields.check());
  return audio;
}

Result<LayerFile> parse_layer(const JsonValue& object) {
  LayerFile file{TRY(parse_file(object)), {}};
  Fields fields(object);
  const JsonValue frames = fields.array("frames");
  TRY(fields.check());
  file.frames.reserve(frames.size());
  for (JsonItems item(frames); item.next();) {
    const auto sizes = sizes_of(item.value());
    if (!sizes) {
      return fail(concat("frames[", file.frames.size(), "]: is not three whole numbers from 0 to ",
                         kMaxUint32));
    }
    file.frames.push_back(*sizes);
  }
  return file;
}

/// Parses the times and numbers of points of a segment's frames.
Result<void> parse_frames(const JsonValue& times, const JsonValue& points, Segment& segment) {
  segment.times_us.reserve(times.size());
  for (JsonItems item(times); item.next();) {
    const std::optional<std::uint64_t> time = item.value().integer();
    if (!time || *time > kMaxInteger) {
      return fail(concat("times_us[", segment.times_us.size(),
                         "]: is not a whole number from 0 to ", kMaxInteger));
    }
    segment.times_us.push_back(*time);
  }
  segment.points.reserve(points.size());
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
  return cube;
}

Result<Segment> parse_segment(const JsonValue& object) {
  Fields fields(object);
  Segment segment;
  segment.first_frame = static_cast<std::uint32_t>(fields.integer("first_frame", kMaxUint32));
  const JsonValue* cube_value = fields.value("cube");
  const JsonValue times = fields.array("times_us");
  const JsonValue points = fields.array("points");
  const JsonValue files = fields.array("files");
  TRY(fields.check());
  segment.cube = TRY(at_place("cube", parse_cube(*cube_value)));
  TRY(parse_frames(times, points, segment));
  for (JsonItems item(files); item.next();) {
    const std::string place = concat("files[", segment.layers.size(), "]");
    segment.layers.push_back(TRY(at_place(place, parse_layer(item.value()))));
  }
  if (fields.has("sound")) {
    segment.sound = TRY(at_place("sound", parse_file(*fields.value("sound"))));
  }
  return segment;
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

Result<CodingError> parse_coding_error(const JsonValue& object) {
  Fields fields(object);
  CodingError error;
  error.frames = static_cast<std::uint32_t>(fields.integer("frames", kMaxUint32));
  error.d1 = fields.number("d1");
  if (fields.has("d2")) error.d2 = fields.number("d2");
  if (fields.has("luma")) error.luma = fields.number("luma");
  TRY(fields.check());
  return error;
}

Result<Cleaning> parse_cleaning(const JsonValue& object) {
  Fields fields(object);
  Cleaning cleaning;
  cleaning.frames = static_cast<std::uint32_t>(fields.integer("frames", kMaxUint32));
  cleaning.removed = fields.integer("removed_points", kMaxInteger);
  cleaning.spacing = fields.number("spacing");
  cleaning.noise = fields.number("noise");
  cleaning.radius = fields.number("radius");
  TRY(fields.check());
  return cleaning;
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
  TRY(fields.check());
  manifest.bounds = TRY(at_place("bounds", parse_box(*bounds)));
  if (fields.has("captured_us")) manifest.captured_us = fields.integer("captured_us", kMaxInteger);
  if (fields.has("max_error")) manifest.max_error = fields.number("max_error");
  if (fields.has("coding_error")) {
    manifest.coding_error =
        TRY(at_place("coding_error", parse_coding_error(*fields.value("coding_error"))));
  }
  if (fields.has("cleaning")) {
    manifest.cleaning = TRY(at_place("cleaning", parse_cleaning(*fields.value("cleaning"))));
  }
  if (fields.has("tables")) {
    manifest.tables = TRY(at_place("tables", parse_file(*fields.value("tables"))));
  }
  if (fields.has("audio")) {
    manifest.audio = TRY(at_place("audio", parse_audio(*fields.value("audio"))));
  }
  if (fields.has("partial")) manifest.partial = fields.boolean("partial");
  if (fields.has("normals_estimated"))
    manifest.normals_estimated = fields.boolean("normals_estimated");
  TRY(fields.check());
  if (fields.has("live")) {
    manifest.live = TRY(at_place("live", parse_live(*fields.value("live"))));
  }
  for (JsonItems item(segments); item.next();) {
    const std::string place = concat("segments[", manifest.segments.size(), "]");
    manifest.segments.push_back(TRY(at_place(place, parse_segment(item.value()))));
  }
  TRY(check_manifest(manifest));
  return manifest;
}

}  // namespace

Result<Manifest> parse_manifest(std::string_view text) {
  if (text.size() > kMaxManifestBytes) {
    return fail(ErrorCode::limit, concat("is longer than ", kMaxManifestBytes, " bytes"));
  }
  return or_out_of_memory([&]() -> Result<Manifest> { return parse_root(TRY(parse_json(text))); });
}

}  // namespace pointreel
