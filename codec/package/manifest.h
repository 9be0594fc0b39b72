#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "pointreel/error.h"
#include "pointreel/package.h"

namespace pointreel {

/// The text of reel.json, with one line for each segment and a line feed at its end. The manifest
/// is not checked: parse the text with `parse_manifest` before publishing it.
std::string write_manifest(const Manifest& manifest);

/// The same in two steps, for a manifest to which segments are added: the line of a segment, to be
/// made once, and the text with such lines instead of the manifest's own segments.
std::string write_segment(const Segment& segment);
std::string write_manifest(const Manifest& manifest, std::span<const std::string> segments);

/// The file beside reel.json that holds the newest segments of a recording: PROTOCOL.md,
/// "Recordings".
inline constexpr const char* kJournalName = "reel.journal";
/// A line of the journal: a segment, as its line in the manifest, and a manifest's other members.
std::string write_journal_line(const Manifest& manifest, const std::string& segment);

/// The text of a manifest in this folder, with what the journal adds to it, if there is one. The
/// text itself may be anything: parse the result. Errors begin with the path of the journal.
///
/// Trust: the journal may be hostile. One longer than kMaxManifestBytes is an error.
Result<std::string> with_journal(const std::filesystem::path& folder, std::string text);

/// Reads FOLDER/reel.json and the journal, if there is one. The error begins with the path; its
/// code is `not_found` if FOLDER is not a package.
Result<Manifest> read_manifest(const std::filesystem::path& folder);

}  // namespace pointreel
