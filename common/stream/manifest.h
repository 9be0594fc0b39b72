#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "pointreel/error.h"
#include "pointreel/package.h"

namespace pointreel {

/// The text of reel.json, ending in a line feed; one line for each segment. What it holds must be
/// what `parse_manifest` accepts: parse it before publishing it.
std::string write_manifest(const Manifest& manifest);

/// The same in two steps, for a manifest that gets segment after segment: the line of each, once,
/// and the text with these lines in the place of the manifest's own segments.
std::string write_segment(const Segment& segment);
std::string write_manifest(const Manifest& manifest, std::span<const std::string> segments);

/// Reads FOLDER/reel.json; the error begins with the path and says so if FOLDER is no package.
Result<Manifest> read_manifest(const std::filesystem::path& folder);

}  // namespace pointreel
