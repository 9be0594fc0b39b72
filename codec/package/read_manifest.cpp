#include <map>
#include <optional>
#include <string_view>
#include <system_error>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "codec/package/manifest.h"
#include "common/base/json_value.h"
#include "common/base/try.h"
#include "common/file_system/open_file.h"

namespace pointreel {
namespace {

namespace fs = std::filesystem;

/// The members of a manifest, none of them checked, as views of texts that outlive them.
struct Members {
  std::map<std::string_view, std::string_view> head;  ///< by key, with its quotes
  std::vector<std::string_view> segments;
};

/// Nothing if the text is not an object with an array of segments.
std::optional<Members> members_of(const JsonValue& object) {
  Members members;
  bool complete = false;
  for (JsonItems item(object); item.next();) {
    if (!is_text(item.key(), "segments")) {
      members.head[item.key().text()] = item.value().text();
      continue;
    }
    complete = item.value().is_array();
    for (JsonItems segment(item.value()); segment.next();) {
      members.segments.push_back(segment.value().text());
    }
  }
  if (!object.is_object() || !complete) return std::nullopt;
  return members;
}

std::string text_of(const Members& members) {
  std::string text = "{";
  for (const auto& [key, value] : members.head) text.append(key).append(":").append(value) += ',';
  return fmt::format("{}\"segments\":[{}]}}\n", text, fmt::join(members.segments, ","));
}

/// The number of frames of a segment that has not been checked.
std::uint64_t count_frames(std::string_view segment) {
  std::uint64_t frames = 0;
  for (JsonItems item{JsonValue(segment)}; item.next();) {
    if (is_text(item.key(), "times_us")) frames = item.value().size();
  }
  return frames;
}

std::optional<std::uint64_t> first_frame_of(std::string_view segment) {
  std::optional<std::uint64_t> first;
  for (JsonItems item{JsonValue(segment)}; item.next();) {
    if (is_text(item.key(), "first_frame")) first = item.value().integer();
  }
  return first;
}

}  // namespace

Result<std::string> with_journal(const fs::path& folder, std::string text) {
  const fs::path path = folder / kJournalName;
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return text;
  const auto root = parse_json(text);
  if (!root) return text;
  std::optional<Members> manifest = members_of(*root);
  if (!manifest) return text;
  std::uint64_t frames = 0;
  for (const std::string_view segment : manifest->segments) frames += count_frames(segment);
  bool more = false;
  const std::string journal = TRY(at_place(path.string(), read_text(path, kMaxManifestBytes)));
  std::size_t begin = 0, number = 1;
  // What comes after the last line feed was cut off while it was written.
  for (std::size_t end = 0; (end = journal.find('\n', begin)) != std::string::npos; ++number) {
    const auto line = parse_json(std::string_view(journal).substr(begin, end - begin));
    begin = end + 1;
    const std::string place = fmt::format("{}: line {}", path.string(), number);
    if (!line) return fail_at(place, line.error());
    const std::optional<Members> entry = members_of(*line);
    std::optional<std::uint64_t> first;
    if (entry && entry->segments.size() == 1) first = first_frame_of(entry->segments.front());
    if (!first) return fail(fmt::format("{}: is not one segment of a recording", place));
    // The manifest may be newer than the line, or, if it was replaced just now, older.
    if (*first < frames) continue;
    if (*first > frames) break;
    frames += count_frames(entry->segments.front());
    manifest->segments.push_back(entry->segments.front());
    for (const auto& [key, value] : entry->head) manifest->head[key] = value;
    more = true;
  }
  return more ? text_of(*manifest) : text;
}

Result<Manifest> read_manifest(const fs::path& folder) {
  const fs::path path = folder / kManifestName;
  std::error_code error;
  if (!fs::is_regular_file(path, error)) {
    if (error == std::errc::permission_denied) {
      return fail(ErrorCode::io,
                  fmt::format("{}: cannot be read: {}", folder.string(), error.message()));
    }
    if (!fs::exists(folder, error)) {
      return fail(ErrorCode::not_found, fmt::format("{}: no such file or folder", folder.string()));
    }
    return fail(ErrorCode::not_found,
                fmt::format("{}: is not a package: it has no {}", folder.string(), kManifestName));
  }
  std::string text = TRY(at_place(path.string(), read_text(path, kMaxManifestBytes)));
  text = TRY(with_journal(folder, std::move(text)));
  return at_place(path.string(), parse_manifest(text));
}

}  // namespace pointreel
