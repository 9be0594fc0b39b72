#include "codec/files/guess_reading.h"

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "codec/files/byte_source.h"
#include "codec/files/cloud_file.h"
#include "codec/files/column_guess.h"
#include "codec/files/format_table.h"
#include "codec/files/numpy.h"
#include "codec/files/sample.h"
#include "codec/files/sweep.h"
#include "codec/files/text_points.h"
#include "common/base/letter_case.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLookedFrames = 9;  // frames
/// A frame of which no part can be taken is read twice only if there are others.
constexpr std::size_t kSmall = std::size_t{2} << 20;

bool has_unnamed_columns(CloudFormat format) {
  return format == CloudFormat::text || format == CloudFormat::sweep ||
         format == CloudFormat::nuscenes_sweep || format == CloudFormat::numpy;
}

/// The first, the last, and some between.
std::vector<const CloudFrame*> some_of(const std::vector<CloudFrame>& frames) {
  const std::size_t count = std::min(kLookedFrames, frames.size());
  std::vector<const CloudFrame*> some;
  for (std::size_t i = 0; i < count; ++i)
    some.push_back(&frames[count == 1 ? 0 : i * (frames.size() - 1) / (count - 1)]);
  return some;
}

/// A pipe can be read only once.
Result<ByteSource> open(const fs::path& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return fail(ErrorCode::invalid, "is not a regular file");
  return ByteSource::open(path);
}

/// Nothing for files that tell everything themselves, and for those that cannot be read.
std::optional<Bytes> sample_of(const CloudFrame& frame, CloudFormat format) {
  if (frame.recording != nullptr) {
    if (format != CloudFormat::point_cloud2) return std::nullopt;
    auto bytes = frame.recording->read(frame.index);
    return bytes ? std::optional(std::move(*bytes)) : std::nullopt;
  }
  const auto source = open(frame.file);
  if (!source) return std::nullopt;
  auto sample = sample_of(*source, format);
  return sample ? std::move(*sample) : std::nullopt;
}

std::vector<std::uint64_t> sizes_of(const std::vector<CloudFrame>& frames) {
  std::vector<std::uint64_t> sizes;
  for (const CloudFrame& frame : frames) {
    std::error_code error;
    const std::uintmax_t size = fs::file_size(frame.file, error);
    if (!error) sizes.push_back(size);
  }
  return sizes;
}

/// Scalar fields that have the same value at all points of all clouds that are seen.
class ConstantFields {
 public:
  void see(const PointCloud& cloud) {
    if (cloud.size() < 2) return;
    for (const ScalarField& field : cloud.scalars) {
      if (!may_say_nothing(field.name)) continue;
      const bool constant = is_constant(field);
      const auto [known, is_new] = fields_.try_emplace(field.name);
      if (constant && is_new) known->second = field.values.front();
      if (!constant || known->second != field.values.front()) known->second.reset();
    }
  }
  std::vector<std::string> names() const {
    std::vector<std::string> names;
    for (const auto& [name, value] : fields_)
      if (value) names.push_back(name);
    return names;
  }

 private:
  std::map<std::string, std::optional<float>> fields_;  ///< nothing: of several values
};

class ReadingGuess {
 public:
  ReadingGuess(CloudSequence& sequence, CloudFormat format)
      : sequence_(sequence), format_(format), looked_(some_of(sequence.frames)) {}

  void guess_columns() {
    if (format_ == CloudFormat::numpy) {
      sequence_.reading.columns = numpy_columns();
    } else if (format_ == CloudFormat::text || format_ == CloudFormat::sweep) {
      sequence_.reading.columns = sampled_columns();
    }
    if (first_counts_) {
      sequence_.warnings.push_back(fmt::format(
          "{}: the first column numbers the points, but is read as x; if that is wrong, "
          "--columns -,x,y,z skips it",
          sequence_.frames.front().name()));
    }
    if (!sequence_.reading.columns.empty())
      sequence_.guesses.push_back(
          fmt::format("{} (--columns changes it)", fmt::join(sequence_.reading.columns, " ")));
  }

  /// What only points tell.
  void look_at_points(const Reading& asked) {
    ConstantFields constants;
    bool seen = false;
    double full_color = 0.0;  // of the brightest frame
    bool odd_colors = false;
    for (const CloudFrame* frame : looked_) {
      const auto sample = sample_of(*frame, format_);
      if (!sample) continue;
      if (sequence_.frames.size() == 1 && sample->size() > kSmall) return;
      ReadNotes notes;
      const Reading reading{sequence_.reading.columns, 0.0};
      const auto cloud = read_points(ByteSource(ByteView(*sample)), format_, {}, reading, notes);
      if (!cloud) continue;
      seen = true;
      constants.see(*cloud);
      if (!cloud->colors.empty() && notes.full_color > full_color) {
        full_color = notes.full_color;
        odd_colors = notes.odd_colors;
      }
    }
    if (asked.full_color == 0.0) {
      sequence_.reading.full_color = full_color;
      if (odd_colors)
        sequence_.guesses.push_back(
            fmt::format("colours up to {} (--color-max changes it)", full_color));
    }
    if (!asked.omit_constant && seen && sequence_.frames.size() > 1)
      sequence_.reading.omit_constant = constants.names();
  }

 private:
  std::vector<std::string> sampled_columns() {
    std::vector<Bytes> samples;
    for (const CloudFrame* frame : looked_)
      if (auto sample = sample_of(*frame, format_)) samples.push_back(std::move(*sample));
    const std::vector<ByteView> views(samples.begin(), samples.end());
    if (format_ == CloudFormat::sweep)
      return guess_sweep_columns(sizes_of(sequence_.frames), views);
    const std::string name = sequence_.frames.front().file.filename().string();
    return guess_text_columns(views, in_small_letters(name).ends_with(".pts"), first_counts_);
  }

  std::vector<std::string> numpy_columns() const {
    ColumnGuess guess;
    std::size_t columns = 0;
    for (const CloudFrame* frame : looked_) {
      const auto source = open(frame->file);
      const std::size_t seen = source ? look_at_numpy(*source, {}, guess) : 0;
      if (columns == 0) columns = seen;
    }
    return columns > 3 ? guess.text_names(columns, false) : std::vector<std::string>();
  }

  CloudSequence& sequence_;
  const CloudFormat format_;
  const std::vector<const CloudFrame*> looked_;
  bool first_counts_ = false;  ///< the first column of text numbers the points
};

/// By its first bytes, or else by its name.
CloudFormat format_of_frame(const CloudFrame& frame) {
  if (frame.recording != nullptr) return frame.recording->format();
  Bytes room;
  const auto source = open(frame.file);
  if (!source) return CloudFormat::unknown;
  const auto begin = source->view(0, 256, room);
  return begin ? format_of(*begin, frame.file.filename().string()) : CloudFormat::unknown;
}

}  // namespace

void guess_reading(CloudSequence& sequence, const Reading& asked) {
  sequence.reading = asked;
  const CloudFrame& first = sequence.frames.front();
  const CloudFormat format = format_of_frame(first);
  if (!asked.columns.empty() && !has_unnamed_columns(format)) {
    sequence.warnings.push_back(
        fmt::format("{}: tells itself what points have: --columns is not used", first.name()));
  }
  ReadingGuess guess(sequence, format);
  if (asked.columns.empty()) guess.guess_columns();
  guess.look_at_points(asked);
  // Files of other formats, which a user may name, have other columns.
  const auto named_format = [](const CloudFrame& frame) {
    return frame.recording != nullptr ? frame.recording->format()
                                      : format_of({}, frame.file.filename().string());
  };
  const auto reading = std::make_shared<const Reading>(sequence.reading);
  const auto others = std::make_shared<const Reading>(asked.columns, sequence.reading.full_color);
  for (CloudFrame& frame : sequence.frames)
    frame.reading = named_format(frame) == named_format(first) ? reading : others;
}

}  // namespace pointreel
