#pragma once

#include <filesystem>
#include <span>
#include <string>

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

/// Reads FOLDER/reel.json. The error begins with the path; its code is `not_found` if FOLDER is not
/// a package.
Result<Manifest> read_manifest(const std::filesystem::path& folder);

}  // namespace pointreel
