#pragma once

#include <filesystem>
#include <string_view>

#include "client/options/settings.h"
#include "pointreel/error.h"

/// The file in which a window keeps its settings: a JSON object whose names are those of the option
/// table.
///
///   {"window": [1280, 720], "mode": "voxel", "edl": 0.5, "loop": false, "drawing_panel": true}
///
/// Every name may be absent. Unknown names, perhaps of a newer version, are ignored and kept.
namespace pointreel {

/// "pointreel/player.json" in $XDG_CONFIG_HOME, or else in ~/.config; empty if neither is set.
std::filesystem::path default_settings_file();

/// Puts the file's values into `settings`, which stay as they are on an error, and also if there is
/// no such file. Trusts nothing: at most 64 KiB are read, of a regular file only, and a value that
/// the command line would refuse is an error, which names the file.
Result<void> read_settings(const std::filesystem::path& file, Settings& settings);
/// The same from the text of a file.
Result<void> parse_settings(std::string_view text, Settings& settings);

/// Puts the values that differ between `begun` and `ended` into the file. The file is replaced
/// atomically, and created if there is none. One that cannot be read is an error and stays as it
/// is.
Result<void> write_settings(const std::filesystem::path& file, const Settings& begun,
                            const Settings& ended);

}  // namespace pointreel
