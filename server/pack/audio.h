#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "pointreel/error.h"
#include "pointreel/package.h"
#include "server/store/package_files.h"

/// The sound of a package. It is made by ffmpeg, from any file that ffmpeg reads.
namespace pointreel {

/// The name under which sound is unpacked.
inline constexpr const char* kUnpackedAudio = "audio.opus";

/// Warns of sound that lies beside the frames of these inputs, where it was unpacked.
void warn_of_unpacked_audio(const std::vector<std::filesystem::path>& inputs,
                            std::vector<std::string>& warnings);

/// Whether ffmpeg is there to read the file, and the file too. Errors: `not_found`.
Result<void> check_audio_source(const std::filesystem::path& source);

/// Gets a line, which begins with the source, if ffmpeg found something wrong but all the sound is
/// there.
using OnWarning = std::function<void(const std::string& line)>;

/// Sound that was encoded for a reel.
struct EncodedAudio {
  AudioFile file;
  bool cut_off = false;                         ///< the source has more
  std::optional<std::uint64_t> source_us = {};  ///< the length of the source, if it is known
};

/// "0.533 s of 3 s (the rest was cut off)".
std::string encoded_audio_text(const EncodedAudio& audio);

/// Encodes the first sound track of a file, as stereo, and writes it into a package's folder, under
/// a name of its own. What lies beyond `duration_us` is left out. Errors begin with the source, or
/// with the file that cannot be written; a source that is cut off, or so damaged that its sound
/// would be shorter, is one.
Result<EncodedAudio> write_audio(const std::filesystem::path& source,
                                 const std::filesystem::path& folder, std::uint64_t duration_us,
                                 const std::stop_token& stop = {}, const OnWarning& warn = {});

/// Gives a package sound, in place of the sound that it has, or takes it away if there is no
/// source. The package is valid at any moment. Errors as above, those of read_manifest, `argument`
/// for a recording that has not ended, and `io` if another program changes or replaces the package
/// meanwhile.
Result<std::optional<AudioFile>> replace_audio(const std::filesystem::path& package,
                                               const std::optional<std::filesystem::path>& source,
                                               const std::stop_token& stop = {},
                                               const OnWarning& warn = {});

/// Decodes the sound of a package in full, and compares it with the manifest. Its size and checksum
/// are not looked at.
Result<void> check_audio(const PackageFiles& files, const AudioFile& audio);

}  // namespace pointreel
