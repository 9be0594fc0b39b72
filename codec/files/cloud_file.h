#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "codec/files/cloud_format.h"
#include "codec/files/read_notes.h"
#include "codec/files/reading.h"
#include "codec/files/recording.h"
#include "pointreel/bytes.h"
#include "pointreel/cloud.h"
#include "pointreel/codec.h"
#include "pointreel/error.h"
#include "pointreel/up.h"

namespace pointreel {

/// A cloud from a file that is safe to use (see `sanitize`; unusable radii are estimated), and what
/// was repaired for that.
struct LoadedCloud {
  PointCloud cloud;
  std::size_t left_out = 0;           ///< points of the file
  std::vector<std::string> warnings;  ///< lines without the file's name
  std::vector<std::string> unread;    ///< names of what points have in the file and was skipped
  double full_color = 0.0;            ///< ReadNotes::full_color
};

/// Reads the points of a file of any format (cloud_format.h), which may also be a mesh. The error
/// does not contain the file's name.
///
/// `limits` holds where few bytes may stand for many points, as in Draco.
///
/// Trust: the bytes may be hostile. Memory is bounded by their number, and by `limits`.
Result<LoadedCloud> read_cloud(ByteView bytes, CloudFormat format, const DecodeLimits& limits = {},
                               const Reading& reading = {});
/// The same for formats that are recognised by their first bytes.
Result<LoadedCloud> read_cloud(ByteView bytes, const DecodeLimits& limits = {},
                               const Reading& reading = {});

/// The cloud as read_cloud returns it: sanitized, with what was repaired, and without what says
/// nothing.
LoadedCloud usable_cloud(PointCloud cloud, CloudFormat format, ReadNotes notes = {},
                         const Reading& reading = {}, const Executor& executor = {});

/// Whether it is the name of a field that cameras, scanners and programs write although they have
/// nothing to say. Those that are the same at all points are left out.
bool may_say_nothing(std::string_view name);
/// Whether it is the same at all points.
bool is_constant(const ScalarField& field);

/// Reads a file. Its format is recognised by its first bytes, or else by its name. The error begins
/// with the path.
Result<LoadedCloud> read_cloud_file(const std::filesystem::path& path,
                                    const DecodeLimits& limits = {});
/// The same of files that come one after another: what `reading` lacks is guessed by the first.
Result<LoadedCloud> read_next_cloud_file(const std::filesystem::path& path, Reading& reading,
                                         const DecodeLimits& limits = {});

/// One frame of a sequence: a file, or one of the clouds in a recording.
struct CloudFrame {
  std::filesystem::path file;
  std::shared_ptr<const Recording> recording = nullptr;
  std::uint32_t index = 0;                           ///< in the recording
  std::optional<std::uint64_t> time_us = {};         ///< where the recording tells
  std::shared_ptr<const Reading> reading = nullptr;  ///< of the sequence; null: by the file alone

  std::string name() const;  ///< the path, or "PATH: message 3"
};

/// Frames in order.
struct CloudSequence {
  std::vector<CloudFrame> frames;
  /// When each frame is shown, in microseconds from the first, and the end of the last. Empty
  /// unless all frames have times, in order.
  std::vector<std::uint64_t> times_us;
  double fps = 0.0;                   ///< by the median spacing of `times_us`; 0 without
  std::vector<std::string> warnings;  ///< of list_cloud_files, and about what is missing
  std::size_t lost_parts = 0;         ///< RecordingLoss::parts
  Reading reading;                    ///< as it was asked for and guessed
  std::vector<std::string> guesses;   ///< what was guessed of it, and how to change it

  std::uint64_t end_us() const;
  /// Unix time of the first frame; nothing if its time is counted from another moment.
  std::optional<std::uint64_t> captured_us() const;
  /// Of the frames, as places_by_number tells them; empty if no number is missing.
  std::vector<std::uint64_t> places;
  /// Gives the frames the times that they had if none were missing.
  void keep_gaps(double frames_per_second);

  /// Sets `times_us` and `fps` by the times of the frames.
  void find_times();
};

struct ListOptions {
  std::string topic = {};                   ///< of recordings that have several
  std::uint64_t max_memory = kFrameMemory;  ///< of the parts of recordings that are kept
  bool best_effort = false;                 ///< leave damaged parts of recordings out
  Reading reading = {};                     ///< what is not to be guessed
  std::function<bool()> stopped = {};       ///< true ends waiting for a pipe; empty: never
};

/// The frames of list_cloud_files: each file, and each cloud of recordings (.mcap, and depth in
/// .mkv and folders). The error begins with the path.
Result<CloudSequence> list_cloud_frames(const std::vector<std::filesystem::path>& inputs,
                                        const ListOptions& options = {});

/// The error begins with the frame's name.
Result<LoadedCloud> read_cloud_frame(const CloudFrame& frame, const DecodeLimits& limits = {});

/// A frame as it is stored, to be read later.
struct CloudBytes {
  Bytes bytes;
  CloudFormat format = CloudFormat::unknown;
};
/// At most `max_bytes`. The error begins with the frame's name.
Result<CloudBytes> fetch_cloud_frame(const CloudFrame& frame, std::uint64_t max_bytes);

/// The axis that points up in a file by its format; nothing if that does not tell.
std::optional<Up> up_of_file(const std::filesystem::path& path);
std::optional<Up> up_of_frame(const CloudFrame& frame);

}  // namespace pointreel
