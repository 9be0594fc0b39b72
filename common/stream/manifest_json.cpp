#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "common/octree/morton.h"
#include "common/stream/json_fields.h"
#include "common/stream/package.h"

// The text of reel.json, read and written.
namespace pointreel {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

constexpr const char* kFormatName = "pointreel";
constexpr std::uint64_t kMaxUint32 = 0xffffffffu;

/// ---- reading ----

bool is_uint32(const json& v) {
  return v.is_number_unsigned() && v.get<std::uint64_t>() <= kMaxUint32;
}

/// What all files have.
Result<PackageFile> parse_file(const json& object, std::uint64_t max_bytes) {
  Fields fields(object);
  PackageFile file;
  file.path = fields.text("path");
  file.bytes = fields.integer("bytes", max_bytes);
  const std::string checksum = fields.text("xxh3");
  if (fields.error()) return tl::unexpected(*fields.error());

  if (!is_file_name(file.path)) return fail("path: is not a plain file name of the package");
  const std::optional<std::uint64_t> value = parse_hex(checksum);
  if (!value) return fail("xxh3: is not 16 lowercase hexadecimal digits");
  file.checksum = *value;
  return file;
}

Result<LayerFile> parse_layer(const json& object, std::uint32_t frame_count) {
  Result<PackageFile> whole = parse_file(object, kMaxInteger);
  if (!whole) return tl::unexpected(whole.error());
  LayerFile file{std::move(*whole), {}};
  Fields fields(object);
  const json& frames = fields.array("frames");
  if (fields.error()) return tl::unexpected(*fields.error());
  if (frames.size() != frame_count) {
    return fail(fmt::format("frames: {} entries for {} frames", frames.size(), frame_count));
  }
  file.frames.reserve(frames.size());
  std::uint64_t sum = 0;
  for (const json& sizes : frames) {
    if (!sizes.is_array() || sizes.size() != 3 ||
        !std::all_of(sizes.begin(), sizes.end(), is_uint32)) {
      return fail(fmt::format("frames[{}]: is not three whole numbers from 0 to {}",
                              file.frames.size(), kMaxUint32));
    }
    file.frames.push_back({sizes[0].get<std::uint32_t>(), sizes[1].get<std::uint32_t>(),
                           sizes[2].get<std::uint32_t>()});
    sum += file.frames.back().total();
  }
  if (sum != file.bytes) {
    return fail(fmt::format("bytes: {}, but its frames take {}", file.bytes, sum));
  }
  return file;
}

/// Which chunks a frame may have: geometry in the base and wherever there is anything; no finer
/// layer above a missing one; no attribute that the reel does not have.
Result<void> check_chunks(const Manifest& manifest, const Segment& segment) {
  for (std::size_t layer = 0; layer < segment.layers.size(); ++layer) {
    for (std::uint32_t i = 0; i < segment.frame_count(); ++i) {
      const LayerSizes& sizes = segment.layers[layer].frames[i];
      const char* fault = nullptr;
      if (sizes.geometry == 0 && (layer == 0 || sizes.total() > 0)) {
        fault = "has no geometry";
      } else if (layer > 0 && sizes.geometry > 0 &&
                 segment.layers[layer - 1].frames[i].geometry == 0) {
        fault = "refines a layer that the frame does not have";
      } else if (sizes.colors > 0 && !manifest.colors) {
        fault = "has colours in a reel without colours";
      } else if (sizes.normals > 0 && !manifest.normals) {
        fault = "has normals in a reel without normals";
      }
      if (fault != nullptr) return fail(fmt::format("files[{}].frames[{}]: {}", layer, i, fault));
    }
  }
  return {};
}

/// `segment` has as many frames as `times`; `last_time` is that of the frame before.
Result<void> parse_frames(const json& times, const json& points, std::uint64_t last_time,
                          Segment& segment) {
  if (times.empty()) return fail("times_us: is empty, a segment has at least one frame");
  if (points.size() != times.size()) {
    return fail(fmt::format("points: {} entries for {} frames", points.size(), times.size()));
  }
  segment.times_us.reserve(times.size());
  for (const json& time : times) {
    if (!time.is_number_unsigned() || time.get<std::uint64_t>() > kMaxInteger) {
      return fail(fmt::format("times_us[{}]: is not a whole number from 0 to {}",
                              segment.times_us.size(), kMaxInteger));
    }
    if (time.get<std::uint64_t>() < last_time) {
      return fail(fmt::format("times_us[{}]: {} comes after {}", segment.times_us.size(),
                              time.get<std::uint64_t>(), last_time));
    }
    last_time = time.get<std::uint64_t>();
    segment.times_us.push_back(last_time);
  }
  segment.points.reserve(points.size());
  for (const json& count : points) {
    if (!is_uint32(count)) {
      return fail(fmt::format("points[{}]: is not a whole number from 0 to {}",
                              segment.points.size(), kMaxUint32));
    }
    segment.points.push_back(count.get<std::uint32_t>());
  }
  return {};
}

Result<Cube> parse_cube(const json& object) {
  Fields fields(object);
  const Cube cube{fields.vector("origin"), fields.number("edge")};
  if (fields.error()) return tl::unexpected(*fields.error());
  const glm::dvec3 far = cube.origin + cube.edge;
  if (!(cube.edge > 0.0) || !std::isfinite(far.x + far.y + far.z)) {
    return fail("edge: is not a finite number above 0");
  }
  return cube;
}

/// `manifest` holds all that stands before the segments and the segments before this one.
Result<Segment> parse_segment(const json& object, const Manifest& manifest, std::uint32_t first,
                              std::uint64_t last_time) {
  Fields fields(object);
  Segment segment;
  segment.first_frame = static_cast<std::uint32_t>(fields.integer("first_frame", kMaxUint32));
  const json* cube_value = fields.value("cube");
  const json& times = fields.array("times_us");
  const json& points = fields.array("points");
  const json& files = fields.array("files");
  if (fields.error()) return tl::unexpected(*fields.error());

  if (segment.first_frame != first) {
    return fail(fmt::format("first_frame: {}, but frames are consecutive and {} comes next",
                            segment.first_frame, first));
  }
  Result<Cube> cube = parse_cube(*cube_value);
  if (!cube) return fail_at("cube", cube.error());
  segment.cube = *cube;
  if (const Result<void> frames = parse_frames(times, points, last_time, segment); !frames) {
    return tl::unexpected(frames.error());
  }
  if (files.size() != manifest.layer_names.size()) {
    return fail(fmt::format("files: {} for {} layers", files.size(), manifest.layer_names.size()));
  }
  for (const json& entry : files) {
    Result<LayerFile> file = parse_layer(entry, segment.frame_count());
    if (!file) return fail_at(fmt::format("files[{}]", segment.layers.size()), file.error());
    segment.layers.push_back(std::move(*file));
  }
  if (const Result<void> chunks = check_chunks(manifest, segment); !chunks) {
    return tl::unexpected(chunks.error());
  }
  return segment;
}

Result<void> parse_segments(const json& entries, Manifest& manifest) {
  std::uint64_t frames = 0, last_time = 0;
  std::set<std::string> paths;
  if (manifest.tables) paths.insert(manifest.tables->path);
  bool any_point = false;
  for (const json& entry : entries) {
    const std::string place = fmt::format("segments[{}]", manifest.segments.size());
    Result<Segment> segment =
        parse_segment(entry, manifest, static_cast<std::uint32_t>(frames), last_time);
    if (!segment) return fail_at(place, segment.error());
    frames += segment->frame_count();
    if (frames > kMaxUint32) return fail_at(place, {"a reel has fewer than 2^32 frames"});
    for (const LayerFile& file : segment->layers) {
      if (!paths.insert(file.path).second) {
        return fail_at(place, {fmt::format("\"{}\" is used twice", file.path)});
      }
    }
    last_time = segment->times_us.back();
    for (const std::uint32_t count : segment->points) any_point = any_point || count > 0;
    manifest.segments.push_back(std::move(*segment));
  }
  if (manifest.duration_us < last_time) {
    return fail(fmt::format("duration_us: {}, but the last frame is shown at {}",
                            manifest.duration_us, last_time));
  }
  if (any_point == manifest.bounds.empty()) {
    return fail("bounds: a box if any frame has a point, otherwise null");
  }
  return {};
}

Result<LiveManifest> parse_live(const json& object) {
  Fields fields(object);
  LiveManifest live;
  const std::optional<std::uint64_t> session = parse_hex(fields.text("session"));
  if (!session) fields.refuse("session", "is not 16 lowercase hexadecimal digits");
  live.first_frame = static_cast<std::uint32_t>(fields.integer("first_frame", kMaxUint32));
  live.start_us = fields.integer("start_us", kMaxInteger);
  live.ended = fields.boolean("ended");
  if (fields.error()) return tl::unexpected(*fields.error());
  live.session = *session;
  return live;
}

/// What must hold before a single other member is looked at.
Result<void> check_format(const json& root) {
  Fields fields(root);
  const std::string format = fields.text("format");
  const std::uint64_t version = fields.integer("version", kMaxInteger);
  if (fields.error()) return tl::unexpected(*fields.error());
  if (format != kFormatName) return fail(fmt::format("format: is not \"{}\"", kFormatName));
  if (version > kPackageVersion) {
    return fail(fmt::format(
        "format version {} is newer than {}, the newest that this program reads: update it",
        version, kPackageVersion));
  }
  if (version != kPackageVersion) {
    return fail(fmt::format("format version {} does not exist", version));
  }
  return {};
}

Result<Manifest> parse_root(const json& root) {
  if (const Result<void> format = check_format(root); !format) {
    return tl::unexpected(format.error());
  }
  Fields fields(root);
  Manifest manifest;
  read_reel_head(fields, manifest);
  manifest.duration_us = fields.integer("duration_us", kMaxInteger);
  manifest.depth_min = static_cast<std::uint32_t>(fields.integer("depth_min", kMaxDepth));
  manifest.depth_max = static_cast<std::uint32_t>(fields.integer("depth_max", kMaxDepth));
  const json* bounds = fields.value("bounds");
  const json& segments = fields.array("segments");
  if (manifest.depth_min > manifest.depth_max) fields.refuse("depth_min", "is above depth_max");
  if (fields.error()) return tl::unexpected(*fields.error());
  const Result<Box> box = parse_box(*bounds);
  if (!box) return fail_at("bounds", box.error());
  manifest.bounds = *box;
  if (fields.has("tables")) {
    if (manifest.entropy != "context") return fail("tables: belong to entropy \"context\"");
    Result<PackageFile> tables = parse_file(*fields.value("tables"), kMaxTablesBytes);
    if (!tables) return fail_at("tables", tables.error());
    manifest.tables = std::move(*tables);
  }
  if (fields.has("partial")) manifest.partial = fields.boolean("partial");
  if (fields.has("live")) {
    const Result<LiveManifest> live = parse_live(*fields.value("live"));
    if (!live) return fail_at("live", live.error());
    manifest.live = *live;
  }
  if (const Result<void> all = parse_segments(segments, manifest); !all) {
    return tl::unexpected(all.error());
  }
  return manifest;
}

/// ---- writing ----

ordered_json to_json(const PackageFile& file) {
  return {
      {"path", file.path}, {"bytes", file.bytes}, {"xxh3", fmt::format("{:016x}", file.checksum)}};
}

ordered_json to_json(const LayerFile& file) {
  ordered_json frames = ordered_json::array();
  for (const LayerSizes& sizes : file.frames) {
    frames.push_back({sizes.geometry, sizes.colors, sizes.normals});
  }
  ordered_json whole = to_json(static_cast<const PackageFile&>(file));
  whole["frames"] = std::move(frames);
  return whole;
}

ordered_json to_json(const Segment& segment) {
  ordered_json files = ordered_json::array();
  for (const LayerFile& file : segment.layers) files.push_back(to_json(file));
  return {{"first_frame", segment.first_frame},
          {"cube", {{"origin", vector_json(segment.cube.origin)}, {"edge", segment.cube.edge}}},
          {"times_us", segment.times_us},
          {"points", segment.points},
          {"files", std::move(files)}};
}

}  // namespace

std::string write_segment(const Segment& segment) { return dump(to_json(segment)); }

std::string write_manifest(const Manifest& manifest) {
  std::vector<std::string> lines;
  lines.reserve(manifest.segments.size());
  for (const Segment& segment : manifest.segments) lines.push_back(write_segment(segment));
  return write_manifest(manifest, lines);
}

std::string write_manifest(const Manifest& manifest, std::span<const std::string> segments) {
  ordered_json head = {{"format", kFormatName},
                       {"version", kPackageVersion},
                       {"name", manifest.name},
                       {"codec", manifest.codec}};
  if (!manifest.entropy.empty()) head["entropy"] = manifest.entropy;
  head["fps"] = manifest.fps;
  head["duration_us"] = manifest.duration_us;
  head["up"] = std::string(1, manifest.up);
  head["colors"] = manifest.colors;
  head["normals"] = manifest.normals;
  head["depth_min"] = manifest.depth_min;
  head["depth_max"] = manifest.depth_max;
  head["bounds"] = box_json(manifest.bounds);
  if (manifest.tables) head["tables"] = to_json(*manifest.tables);
  if (manifest.partial) head["partial"] = true;
  if (manifest.live) {
    head["live"] = {{"session", fmt::format("{:016x}", manifest.live->session)},
                    {"first_frame", manifest.live->first_frame},
                    {"start_us", manifest.live->start_us},
                    {"ended", manifest.live->ended}};
  }
  head["layers"] = manifest.layer_names;

  std::string text = "{\n";
  for (const auto& [key, value] : head.items()) {
    text += fmt::format("  \"{}\": {},\n", key, dump(value));
  }
  text += "  \"segments\": [";
  for (std::size_t i = 0; i < segments.size(); ++i) {
    text += i == 0 ? "\n    " : ",\n    ";
    text += segments[i];
  }
  text += segments.empty() ? "]\n}\n" : "\n  ]\n}\n";
  return text;
}

Result<Manifest> parse_manifest(std::string_view text) {
  if (text.size() > kMaxManifestBytes) {
    return fail(fmt::format("is longer than {} bytes", kMaxManifestBytes));
  }
  const Result<json> root = parse_json(text);
  if (!root) return tl::unexpected(root.error());
  return parse_root(*root);
}

}  // namespace pointreel
