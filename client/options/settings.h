#pragma once

#include <filesystem>
#include <functional>
#include <string_view>

#include "client/options/play_options.h"
#include "pointreel/error.h"

/// What a window remembers from one time to the next: its size, how it draws, whether it loops, and
/// its panels. A file of JSON, whose names are those of the options of `pointreel play`:
///
///   {"window": [1280, 720], "mode": "voxel", "edl": 0.5, "loop": false, "drawing_panel": true}
///
/// All may be absent; names that are unknown, of a newer version for instance, are kept and not
/// read.
namespace pointreel {

/// "pointreel/player.json" in $XDG_CONFIG_HOME, or else in ~/.config; empty where there is neither.
std::filesystem::path default_settings_file();

/// Whether an option is on the command line, by its name there: "pixel-size".
using GivenOption = std::function<bool(std::string_view)>;

/// Puts the file's values into options, save where the command line has them. There may be no such
/// file. On an error, options are as they were. Trusts nothing: at most 64 KiB are read, of a
/// regular file only, and a value that the command line would refuse is an error.
Result<void> read_settings(const std::filesystem::path& file, const GivenOption& given,
                           PlayOptions& options);
/// The same from what is in the file.
Result<void> parse_settings(std::string_view text, const GivenOption& given, PlayOptions& options);

/// Puts what is not the same in both into the file, which is replaced at once, and made where there
/// is none. A file that cannot be read is left as it is: an error.
Result<void> write_settings(const std::filesystem::path& file, const PlayOptions& begun,
                            const PlayOptions& ended);

}  // namespace pointreel
