#include "codec/files/cloud_file.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "codec/files/byte_source.h"
#include "codec/files/cloud_folder.h"
#include "codec/files/depth_folder.h"
#include "codec/files/depth_video.h"
#include "codec/files/file_numbers.h"
#include "codec/files/format_table.h"
#include "codec/files/gltf_buffers.h"
#include "codec/files/guess_reading.h"
#include "codec/files/mcap.h"
#include "common/base/out_of_memory.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

namespace fs = std::filesystem;

/// The longest sequence whose times are believed, in microseconds: a month.
constexpr std::uint64_t kLongest = 31ull * 24 * 3600 * 1'000'000;

/// What suffices to recognise a format.
constexpr std::size_t kBegin = 256;

Result<LoadedCloud> read_source(const ByteSource& source, CloudFormat format,
                                const DecodeLimits& limits, const Reading& reading) {
  return or_out_of_memory([&]() -> Result<LoadedCloud> {
    ReadNotes notes;
    PointCloud cloud = TRY(read_points(source, format, limits, reading, notes));
    const double full_color = notes.full_color;
    LoadedCloud loaded =
        usable_cloud(std::move(cloud), format, std::move(notes), reading, limits.executor);
    loaded.full_color = full_color;
    return loaded;
  });
}

Result<CloudFormat> format_of_file(const ByteSource& source, const fs::path& path) {
  Bytes room;
  return format_of(TRY(source.view(0, kBegin, room)), path.filename().string());
}

Result<void> guess(CloudSequence& sequence, const Reading& asked) {
  return or_out_of_memory([&]() -> Result<void> {
    guess_reading(sequence, asked);
    return {};
  });
}

/// The file with its buffers in it, where it is a .gltf file with buffers in other files.
Result<std::optional<Bytes>> embedded(const ByteSource& source, CloudFormat format,
                                      const fs::path& path, std::uint64_t max_bytes) {
  if (format != CloudFormat::gltf) return std::optional<Bytes>();
  return or_out_of_memory([&]() -> Result<std::optional<Bytes>> {
    Bytes room;
    return embed_gltf_buffers(TRY(source.all(room)), path.parent_path(), max_bytes);
  });
}

Result<LoadedCloud> read_file(const fs::path& path, const DecodeLimits& limits,
                              const Reading& reading) {
  const ByteSource source = TRY(at_place(path.string(), ByteSource::open_named(path)));
  const CloudFormat format = TRY(at_place(path.string(), format_of_file(source, path)));
  const auto whole =
      TRY(at_place(path.string(), embedded(source, format, path, limits.max_memory)));
  if (whole) return at_place(path.string(), read_cloud(*whole, format, limits));
  return at_place(path.string(), read_source(source, format, limits, reading));
}

}  // namespace

Result<LoadedCloud> read_cloud(ByteView bytes, CloudFormat format, const DecodeLimits& limits,
                               const Reading& reading) {
  return read_source(ByteSource(bytes), format, limits, reading);
}

Result<LoadedCloud> read_cloud(ByteView bytes, const DecodeLimits& limits, const Reading& reading) {
  return read_cloud(bytes, format_of(bytes, {}), limits, reading);
}

Result<LoadedCloud> read_cloud_file(const fs::path& path, const DecodeLimits& limits) {
  CloudSequence alone;
  alone.frames.push_back({path});
  TRY(guess(alone, {}));
  return read_cloud_frame(alone.frames.front(), limits);
}

Result<LoadedCloud> read_next_cloud_file(const fs::path& path, Reading& reading,
                                         const DecodeLimits& limits) {
  CloudSequence alone;
  alone.frames.push_back({path});
  TRY(guess(alone, reading));
  LoadedCloud loaded = TRY(read_cloud_frame(alone.frames.front(), limits));
  reading = std::move(alone.reading);
  return loaded;
}

std::string CloudFrame::name() const {
  return recording == nullptr ? file.string()
                              : fmt::format("{}: {}", file.string(), recording->name(index));
}

std::uint64_t CloudSequence::end_us() const {
  return times_us.back() + static_cast<std::uint64_t>(1e6 / fps);
}

std::optional<std::uint64_t> CloudSequence::captured_us() const {
  // Before 2001 there were no such recordings; after 2100 it is the clock that errs.
  constexpr std::uint64_t kEarliest = 1'000'000'000'000'000, kLatest = 4'102'444'800'000'000;
  const std::optional<std::uint64_t> first = frames.front().time_us;
  return first && *first >= kEarliest && *first < kLatest ? first : std::nullopt;
}

namespace {

/// Frames per second. Recordings round their times to microseconds: a spacing of 33,333 means 30.
double frame_rate(double spacing_us) {
  const double rate = 1e6 / spacing_us, whole = std::max(1.0, std::round(rate));
  return std::abs(1e6 / whole - spacing_us) <= 1.0 ? whole : rate;
}

}  // namespace

void CloudSequence::find_times() {
  const auto show_evenly = [this](const std::string& why) {
    warnings.push_back(why + ": the frames are shown evenly (--fps says how many a second)");
  };
  if (frames.size() < 2 || !std::ranges::all_of(frames, [](const CloudFrame& frame) {
        return frame.time_us.has_value();
      }))
    return;
  std::vector<std::uint64_t> times;
  const std::uint64_t begin = *frames.front().time_us;
  for (const CloudFrame& frame : frames) {
    const std::uint64_t time = *frame.time_us;
    if (time < begin + (times.empty() ? 0 : times.back()))
      return show_evenly(frame.name() + ": its time is before that of the frame before");
    if (time - begin > kLongest)
      return show_evenly(frame.name() + ": its time is more than 31 days after the first");
    times.push_back(time - begin);
  }
  std::vector<std::uint64_t> spacings;
  for (std::size_t i = 1; i < times.size(); ++i) spacings.push_back(times[i] - times[i - 1]);
  const auto middle = spacings.begin() + std::ssize(spacings) / 2;
  std::nth_element(spacings.begin(), middle, spacings.end());
  if (*middle == 0) return show_evenly("most frames have the time of the frame before");
  if (const auto unseen = std::ranges::count(spacings, 0u); unseen > 0)
    warnings.push_back(
        fmt::format("{} of {} frames have the same time as the next one and are not seen (--fps "
                    "spaces all frames evenly)",
                    unseen, frames.size()));
  times_us = std::move(times);
  fps = frame_rate(static_cast<double>(*middle));
}

namespace {

/// The end of the warning about missing frames.
constexpr std::string_view kGapsAreClosed =
    "; the others are shown one after another (pack --keep-gaps keeps their time)";

}  // namespace

void CloudSequence::keep_gaps(double frames_per_second) {
  if (places.empty()) return;
  for (std::string& line : warnings) {
    if (line.ends_with(kGapsAreClosed)) line.erase(line.size() - kGapsAreClosed.size());
  }
  for (std::size_t i = 0; i < frames.size(); ++i) {
    frames[i].time_us = static_cast<std::uint64_t>(
        std::llround(1e6 * static_cast<double>(places[i]) / frames_per_second));
  }
  find_times();
  fps = frames_per_second;  // and not the median of intervals with gaps in them
}

namespace {

/// Looks for missing frames: among files of one folder, or the pictures of one depth capture.
void check_numbers(CloudSequence& sequence) {
  const bool recorded = sequence.frames.front().recording != nullptr;
  const auto folder_of = [recorded](const CloudFrame& frame) {
    return recorded ? frame.file : frame.file.parent_path();
  };
  std::vector<std::string> names;
  const fs::path folder = folder_of(sequence.frames.front());
  for (const CloudFrame& frame : sequence.frames) {
    if ((frame.recording != nullptr) != recorded || folder_of(frame) != folder || frame.time_us)
      return;
    names.push_back(recorded ? frame.recording->name(frame.index) : frame.file.filename().string());
  }
  const std::string missing = missing_numbers(names);
  if (missing.empty()) return;
  sequence.places = places_by_number(names);
  const std::uint64_t count = sequence.places.back() + 1 - names.size();
  sequence.warnings.push_back(fmt::format(
      "{}: judging by their numbers, {} missing: {}{}", folder.empty() ? "." : folder.string(),
      count == 1 ? "a frame is" : fmt::format("{} frames are", count), missing, kGapsAreClosed));
}

void add_recording(CloudSequence& sequence, const fs::path& file,
                   const std::shared_ptr<const Recording>& recording) {
  for (std::uint32_t i = 0; i < recording->size(); ++i) {
    CloudFrame frame{file, recording, i};
    if (const auto time_ns = recording->time_ns(i)) frame.time_us = *time_ns / 1000;
    sequence.frames.push_back(std::move(frame));
  }
  const RecordingLoss loss = recording->loss();
  for (const std::string& line : loss.warnings)
    sequence.warnings.push_back(fmt::format("{}: {}", file.string(), line));
  sequence.lost_parts += loss.parts;
  for (std::string& line : recording->guesses())
    if (std::ranges::find(sequence.guesses, line) == sequence.guesses.end())
      sequence.guesses.push_back(std::move(line));
}

/// A cloud that came through a pipe, which can be read only once.
class PipedCloud : public Recording {
 public:
  static Result<std::shared_ptr<const Recording>> read_all(const fs::path& path,
                                                           const std::function<bool()>& stopped) {
    ByteSource source = TRY(ByteSource::open_named(path, stopped));
    const CloudFormat format = TRY(format_of_file(source, path));
    return std::make_shared<PipedCloud>(std::move(source), format);
  }
  PipedCloud(ByteSource source, CloudFormat format) : source_(std::move(source)), format_(format) {}

  CloudFormat format() const override { return format_; }
  std::size_t size() const override { return 1; }
  std::optional<std::uint64_t> time_ns(std::size_t) const override { return std::nullopt; }
  std::string name(std::size_t) const override { return "what came through the pipe"; }
  Result<Bytes> read(std::size_t) const override {
    return or_out_of_memory([&]() -> Result<Bytes> {
      Bytes room;
      const ByteView bytes = TRY(source_.all(room));
      return Bytes(bytes.begin(), bytes.end());
    });
  }

 private:
  const ByteSource source_;
  const CloudFormat format_;
};

/// Null for a file of one cloud.
Result<std::shared_ptr<const Recording>> open_recording(const fs::path& path,
                                                        const ListOptions& options) {
  std::error_code ignored;
  const fs::file_status kind = fs::status(path, ignored);
  if (fs::is_directory(kind)) return open_depth_folder(path);
  const std::string name = path.string();
  const CloudFormat format = format_of({}, path.filename().string());
  if (format == CloudFormat::depth_video)
    return at_place(name, open_depth_video(path, options.max_memory));
  if (format != CloudFormat::mcap) {
    if (fs::is_fifo(kind) || fs::is_socket(kind))
      return at_place(name, PipedCloud::read_all(path, options.stopped));
    return nullptr;
  }
  ByteSource source = TRY(at_place(name, ByteSource::open_named(path, options.stopped)));
  return TRY(at_place(name, McapRecording::open(std::move(source), options.topic,
                                                options.max_memory, options.best_effort)));
}

}  // namespace

Result<CloudSequence> list_cloud_frames(const std::vector<fs::path>& inputs,
                                        const ListOptions& options) {
  CloudSequence sequence;
  for (const fs::path& file : TRY(list_cloud_files(inputs, &sequence.warnings))) {
    if (const auto recording = TRY(open_recording(file, options))) {
      add_recording(sequence, file, recording);
    } else {
      sequence.frames.push_back({file});
    }
  }
  const auto has_topics = [](const CloudFrame& frame) {
    return format_of({}, frame.file.filename().string()) == CloudFormat::mcap;
  };
  if (!options.topic.empty() && std::ranges::none_of(sequence.frames, has_topics))
    sequence.warnings.push_back("--topic is not used: there is no MCAP recording");
  check_numbers(sequence);
  sequence.find_times();
  TRY(guess(sequence, options.reading));
  return sequence;
}

Result<LoadedCloud> read_cloud_frame(const CloudFrame& frame, const DecodeLimits& limits) {
  const Reading reading = frame.reading == nullptr ? Reading() : *frame.reading;
  if (frame.recording == nullptr) return read_file(frame.file, limits, reading);
  const std::string name = frame.name();
  const Bytes bytes = TRY(at_place(name, frame.recording->read(frame.index)));
  return at_place(name, read_cloud(bytes, frame.recording->format(), limits, reading));
}

Result<CloudBytes> fetch_cloud_frame(const CloudFrame& frame, std::uint64_t max_bytes) {
  const std::string name = frame.file.string();
  CloudBytes fetched;
  if (frame.recording != nullptr) {
    fetched.bytes = TRY(at_place(frame.name(), frame.recording->read(frame.index)));
    fetched.format = frame.recording->format();
    return fetched;
  }
  const ByteSource source = TRY(at_place(name, ByteSource::open_named(frame.file)));
  fetched.format = TRY(at_place(name, format_of_file(source, frame.file)));
  if (source.size() > max_bytes) {
    return fail(ErrorCode::limit,
                fmt::format("{}: has {} bytes, more than {}", name, source.size(), max_bytes));
  }
  if (auto whole = TRY(at_place(name, embedded(source, fetched.format, frame.file, max_bytes)))) {
    fetched.bytes = std::move(*whole);
    return fetched;
  }
  const ByteView bytes = TRY(at_place(name, source.all(fetched.bytes)));
  if (bytes.data() != fetched.bytes.data()) fetched.bytes.assign(bytes.begin(), bytes.end());
  if (fetched.bytes.size() != source.size() || bytes.size() != source.size())
    return fail(ErrorCode::io, name + ": has become shorter while it was read");
  return fetched;
}

std::optional<Up> up_of_file(const fs::path& path) {
  const auto source = ByteSource::open(path);
  if (!source) return std::nullopt;
  const auto format = format_of_file(*source, path);
  return format ? up_of(*format) : std::nullopt;
}

std::optional<Up> up_of_frame(const CloudFrame& frame) {
  return frame.recording == nullptr ? up_of_file(frame.file) : up_of(frame.recording->format());
}

}  // namespace pointreel
