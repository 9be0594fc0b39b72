#include <fstream>
#include <iterator>
#include <optional>
#include <system_error>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "common/base/try.h"
#include "common/stream/json_fields.h"
#include "common/stream/manifest.h"

namespace pointreel {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Reads a file that is as long as a manifest at most.
Result<std::string> read_text(const fs::path& path) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(path, error);
  if (error) return fail(ErrorCode::io, fmt::format("{}: {}", path.string(), error.message()));
  if (size > kMaxManifestBytes) {
    return fail(ErrorCode::limit,
                fmt::format("{}: is longer than {} bytes", path.string(), kMaxManifestBytes));
  }
  std::ifstream in(path, std::ios::binary);
  std::string text(size, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (!in) return fail(ErrorCode::io, fmt::format("{}: cannot be read", path.string()));
  return text;
}

/// The number of frames of segments that have not been checked.
std::uint64_t count_frames(const json& segments) {
  std::uint64_t frames = 0;
  for (const json& segment : segments) {
    const auto times = segment.find("times_us");
    if (times != segment.end() && times->is_array()) frames += times->size();
  }
  return frames;
}

/// The number of the first frame of an entry's only segment. Nothing if it is not an entry of a
/// journal.
std::optional<std::uint64_t> first_frame_of(const json& entry) {
  const auto segments = entry.find("segments");
  if (segments == entry.end() || !segments->is_array() || segments->size() != 1) return {};
  const auto first = (*segments)[0].find("first_frame");
  if (first == (*segments)[0].end() || !first->is_number_unsigned()) return {};
  return first->get<std::uint64_t>();
}

}  // namespace

Result<std::string> with_journal(const fs::path& folder, std::string text) {
  const fs::path path = folder / kJournalName;
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return text;
  auto parsed = parse_json(text);
  if (!parsed || !parsed->is_object()) return text;
  json& root = *parsed;
  const auto segments = root.find("segments");
  if (segments == root.end() || !segments->is_array()) return text;
  std::uint64_t frames = count_frames(*segments);
  bool more = false;
  const std::string journal = TRY(read_text(path));
  std::size_t begin = 0, number = 1;
  // What comes after the last line feed was cut off while it was written.
  for (std::size_t end = 0; (end = journal.find('\n', begin)) != std::string::npos; ++number) {
    auto entry = parse_json(std::string_view(journal).substr(begin, end - begin));
    begin = end + 1;
    const std::string place = fmt::format("{}: line {}", path.string(), number);
    if (!entry) return fail_at(place, entry.error());
    const std::optional<std::uint64_t> first = first_frame_of(*entry);
    if (!first) return fail(fmt::format("{}: is not one segment of a recording", place));
    // The manifest may be newer than the line, or, if it was replaced just now, older.
    if (*first < frames) continue;
    if (*first > frames) break;
    frames += count_frames((*entry)["segments"]);
    root["segments"].push_back(std::move((*entry)["segments"][0]));
    entry->erase("segments");
    root.update(*entry);
    more = true;
  }
  if (!more) return text;
  return root.dump(-1, ' ', false, json::error_handler_t::replace) + "\n";
}

Result<Manifest> read_manifest(const fs::path& folder) {
  const fs::path path = folder / kManifestName;
  std::error_code error;
  if (!fs::is_regular_file(path, error)) {
    return fail(ErrorCode::not_found,
                fmt::format("{}: is not a package: it has no {}", folder.string(), kManifestName));
  }
  std::string text = TRY(read_text(path));
  text = TRY(with_journal(folder, std::move(text)));
  return at_place(path.string(), parse_manifest(text));
}

}  // namespace pointreel
