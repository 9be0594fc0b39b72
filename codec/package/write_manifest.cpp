#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "codec/core/json_fields.h"
#include "codec/core/write_json.h"
#include "codec/package/manifest.h"

namespace pointreel {
namespace {

using nlohmann::ordered_json;

ordered_json to_json(const PackageFile& file) {
  return {
      {"path", file.path}, {"bytes", file.bytes}, {"xxh3", fmt::format("{:016x}", file.checksum)}};
}

ordered_json to_json(const LayerFile& file) {
  ordered_json frames = ordered_json::array();
  for (const Chunks<std::uint32_t>& sizes : file.frames) {
    frames.push_back({sizes.geometry, sizes.colors, sizes.normals});
  }
  ordered_json whole = to_json(static_cast<const PackageFile&>(file));
  whole["frames"] = std::move(frames);
  return whole;
}

ordered_json to_json(const Segment& segment) {
  ordered_json files = ordered_json::array();
  for (const LayerFile& file : segment.layers) files.push_back(to_json(file));
  ordered_json whole = {
      {"first_frame", segment.first_frame},
      {"cube", {{"origin", vector_json(segment.cube.origin)}, {"edge", segment.cube.edge}}},
      {"times_us", segment.times_us},
      {"points", segment.points},
      {"files", std::move(files)}};
  if (segment.sound) whole["sound"] = to_json(*segment.sound);
  return whole;
}

}  // namespace

std::string write_segment(const Segment& segment) { return dump(to_json(segment)); }

std::string write_manifest(const Manifest& manifest) {
  std::vector<std::string> lines;
  lines.reserve(manifest.segments.size());
  for (const Segment& segment : manifest.segments) lines.push_back(write_segment(segment));
  return write_manifest(manifest, lines);
}

namespace {

/// All members but the segments.
ordered_json head_json(const Manifest& manifest) {
  ordered_json head = {{"format", kPackageFormat},
                       {"version", kPackageVersion},
                       {"name", manifest.name},
                       {"codec", manifest.codec}};
  if (!manifest.entropy.empty()) head["entropy"] = manifest.entropy;
  head["fps"] = manifest.fps;
  head["duration_us"] = manifest.duration_us;
  if (manifest.captured_us) head["captured_us"] = *manifest.captured_us;
  head["up"] = manifest.up.text();
  head["colors"] = manifest.colors;
  head["normals"] = manifest.normals;
  if (!manifest.scalars.empty()) head["scalars"] = scalars_json(manifest.scalars);
  head["depth_min"] = manifest.depth_min;
  head["depth_max"] = manifest.depth_max;
  if (manifest.group_frames > 0) head["group_frames"] = manifest.group_frames;
  head["bounds"] = box_json(manifest.bounds);
  if (manifest.max_error) head["max_error"] = *manifest.max_error;
  if (const auto& error = manifest.coding_error) {
    nlohmann::ordered_json& json =
        head["coding_error"] = {{"frames", error->frames}, {"d1", error->d1}};
    if (error->d2) json["d2"] = *error->d2;
    if (error->luma) json["luma"] = *error->luma;
  }
  if (const auto& cleaning = manifest.cleaning) {
    head["cleaning"] = {{"frames", cleaning->frames},
                        {"removed_points", cleaning->removed},
                        {"spacing", cleaning->spacing},
                        {"noise", cleaning->noise},
                        {"radius", cleaning->radius}};
  }
  if (manifest.tables) head["tables"] = to_json(*manifest.tables);
  if (manifest.audio) {
    head["audio"] = to_json(static_cast<const PackageFile&>(*manifest.audio));
    head["audio"]["samples"] = manifest.audio->samples;
  }
  if (manifest.partial) head["partial"] = true;
  if (manifest.normals_estimated) head["normals_estimated"] = true;
  if (manifest.live) {
    head["live"] = {{"session", fmt::format("{:016x}", manifest.live->session)},
                    {"first_frame", manifest.live->first_frame},
                    {"start_us", manifest.live->start_us},
                    {"ended", manifest.live->ended}};
  }
  head["layers"] = manifest.layer_names;
  return head;
}

}  // namespace

std::string write_manifest(const Manifest& manifest, std::span<const std::string> segments) {
  const ordered_json head = head_json(manifest);
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

std::string write_journal_line(const Manifest& manifest, const std::string& segment) {
  std::string head = dump(head_json(manifest));
  head.pop_back();  // the brace that ends the object
  return fmt::format("{},\"segments\":[{}]}}\n", head, segment);
}

}  // namespace pointreel
