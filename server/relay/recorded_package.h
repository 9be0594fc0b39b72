#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/file_system/descriptor.h"
#include "pointreel/error.h"
#include "server/relay/live_sound_file.h"
#include "server/relay/segmenter.h"

namespace pointreel {

/// A package on disk to which segments are added. However the process ends, the folder is a package
/// of all segments that were added: files get their names when they are complete, and are named by
/// the manifest after that. PROTOCOL.md, "Recordings".
///
/// Rewriting the whole manifest for each segment would take ever longer. Once it is long, segments
/// are therefore appended to a journal, which readers take for a part of the manifest, and the
/// manifest is rewritten when the journal has reached a share of its length. All in all, no more
/// than a constant multiple of the manifest is written.
///
/// While the package grows, its manifest has the member `live`, and its folder is locked.
class RecordedPackage {
 public:
  /// `folder` exists and is empty. The segments' frames and times are counted from these.
  RecordedPackage(std::filesystem::path folder, std::uint32_t first_frame, std::uint64_t start_us);
  RecordedPackage(const RecordedPackage&) = delete;
  RecordedPackage& operator=(const RecordedPackage&) = delete;

  /// Adds a segment. After an error the folder and the segment are as they were before.
  Result<void> add(LiveSegment& segment, const LiveHello& hello);
  /// Adds sound, which the manifest has once the package is complete.
  void add(const LiveSound& sound) { sound_.add(sound); }
  /// Writes the sound and the whole manifest, without `live`, and lets others have the package.
  Result<void> complete(const LiveHello& hello);
  /// Removes the folder, if it is empty.
  void remove() const;

  /// Takes a complete package back, so that segments may be added. False if it is no longer there
  /// as it was left.
  bool take_back();
  bool empty() const { return lines_.empty(); }
  std::size_t manifest_bytes() const { return lines_bytes_; }

 private:
  Manifest head(const LiveHello& hello) const;
  Result<void> write_sound();
  Result<void> write_manifest_file(const Manifest& head);
  Result<void> append_to_journal(const std::string& line);

  const std::filesystem::path folder_;
  const std::uint32_t first_frame_;
  const std::uint64_t start_us_;
  Descriptor lock_;  ///< tells other programs to wait, until the package is complete
  LiveSoundFile sound_;
  std::optional<AudioFile> audio_;  ///< of the manifest on disk
  LiveTotals totals_;
  std::uint64_t duration_us_ = 0;
  std::uint32_t frames_ = 0;
  std::vector<std::string> lines_;  ///< lines of the manifest, one for each segment
  std::size_t lines_bytes_ = 0;
  std::size_t written_bytes_ = 0;  ///< of the manifest on disk
  std::uint64_t written_checksum_ = 0;
  std::size_t journal_bytes_ = 0;
  bool complete_ = false;  ///< the manifest on disk has all segments and no `live`
};

/// Puts what journals hold, and the sound that was growing, into the manifests of recordings in
/// this folder that a killed program left behind, so that web servers serve all of it. `say` gets a
/// line for each that cannot be written, and may be empty. Recordings that another program is
/// writing are left alone.
void complete_recordings(const std::filesystem::path& folder,
                         const std::function<void(const std::string& line)>& say);

}  // namespace pointreel
