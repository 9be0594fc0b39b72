#include "codec/files/sweep.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "codec/files/column_guess.h"
#include "codec/files/named_fields.h"
#include "codec/files/records.h"
#include "codec/files/sample.h"
#include "common/base/concat.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

constexpr std::size_t kLookedPoints = 4096;  // points
constexpr std::size_t kFewest = 3, kMost = 8;
/// In metres. The best scanners see 500.
constexpr float kFurthest = 1e5f;
/// Multiples of the true number of floats differ as little as that, but for chance.
constexpr double kAlike = 1.03;
/// More than the largest floats differ.
constexpr double kUnlike = 1000.0;

float at(ByteView bytes, std::size_t index) {
  return load_number<float>(bytes.data() + index * sizeof(float));
}

bool look_measured(ByteView begin, std::size_t floats) {
  const std::size_t points = std::min(kLookedPoints, begin.size() / (floats * sizeof(float)));
  std::size_t good = 0;
  for (std::size_t i = 0; i < points; ++i) {
    const float x = at(begin, floats * i), y = at(begin, floats * i + 1),
                z = at(begin, floats * i + 2);
    // False for NaN.
    good += std::abs(x) < kFurthest && std::abs(y) < kFurthest && std::abs(z) < kFurthest &&
            (x == 0.0f || std::abs(x) > 1e-12f);
  }
  return good * 2 >= points;
}

/// How much numbers that are `floats` apart differ, on a scale that is even for coordinates and
/// intensities. For numbers of different meaning that is more than for those of one (G. Szekely and
/// M. Rizzo, "Energy statistics", 2013), and neighbouring points are alike besides.
double difference(std::span<const ByteView> samples, std::size_t floats) {
  double sum = 0.0;
  std::size_t count = 0;
  for (const ByteView sample : samples) {
    const std::size_t size = sample.size() / sizeof(float);
    std::array<double, kMost> last{};
    for (std::size_t i = 0; i < size; ++i) {
      const float value = at(sample, i);
      const double even = std::isfinite(value) ? std::asinh(static_cast<double>(value)) : kUnlike;
      double& before = last[i % floats];
      if (i >= floats) sum += std::abs(even - before), ++count;
      before = even;
    }
  }
  // A single point says nothing.
  return count == 0 ? kUnlike : sum / static_cast<double>(count);
}

/// 0 if there is none.
std::size_t guess_floats(std::span<const std::uint64_t> sizes, std::span<const ByteView> samples) {
  std::array<std::size_t, kMost + 1> fits{};
  for (std::size_t floats = kFewest; floats <= kMost; ++floats) {
    fits[floats] =
        static_cast<std::size_t>(std::count_if(sizes.begin(), sizes.end(), [&](std::uint64_t size) {
          return size > 0 && size % (floats * sizeof(float)) == 0;
        }));
  }
  const std::size_t most = *std::max_element(fits.begin(), fits.end());
  if (most == 0) return 0;
  std::array<double, kMost + 1> differences{};
  double least = -1.0;
  for (std::size_t floats = kFewest; floats <= kMost; ++floats) {
    const bool plausible = std::all_of(samples.begin(), samples.end(), [&](ByteView sample) {
      return look_measured(sample, floats);
    });
    if (fits[floats] < most || !plausible) {
      fits[floats] = 0;
      continue;
    }
    differences[floats] = difference(samples, floats);
    if (least < 0.0 || differences[floats] < least) least = differences[floats];
  }
  for (std::size_t floats = kFewest; floats <= kMost; ++floats)
    if (fits[floats] > 0 && differences[floats] <= kAlike * least) return floats;
  return 0;
}

}  // namespace

std::vector<std::string> guess_sweep_columns(std::span<const std::uint64_t> sizes,
                                             std::span<const ByteView> samples) {
  const std::size_t floats = guess_floats(sizes, samples);
  if (floats == 0) return {};
  ColumnGuess guess;
  std::array<double, kMost> row{};
  for (const ByteView sample : samples) {
    const std::size_t points = sample.size() / (floats * sizeof(float));
    for (std::size_t i = 0; i < points; ++i) {
      for (std::size_t column = 0; column < floats; ++column)
        row[column] = at(sample, i * floats + column);
      guess.see(row.data(), floats);
    }
  }
  return guess.sweep_names(floats);
}

std::vector<std::string> nuscenes_columns() { return {"x", "y", "z", "intensity", "ring"}; }

Result<PointCloud> read_sweep(const ByteSource& source, const Reading& reading, ReadNotes& notes) {
  std::vector<std::string> columns = reading.columns;
  if (columns.empty()) {
    const auto sample = TRY(sample_of(source, CloudFormat::sweep));
    const std::uint64_t size = source.size();
    const ByteView view = sample ? ByteView(*sample) : ByteView();
    columns = guess_sweep_columns({&size, 1}, {&view, 1});
    if (columns.empty()) {
      return fail(concat("is not a laser scan: its ", size,
                         " bytes are not points of 3 to 8 floats, most of them within ",
                         std::lround(kFurthest), "; --columns names the floats of a point"));
    }
  }
  const std::size_t size = columns.size() * sizeof(float);
  if (source.size() % size != 0) {
    return fail(concat("has ", source.size(), " bytes, which is not a whole number of points of ",
                       columns.size(), " floats; --columns names those of a point"));
  }
  Bytes room;
  const ByteView begin = TRY(source.view(0, kLookedPoints * size, room));
  if (!look_measured(begin, columns.size())) {
    return fail(concat("most of the first points have impossible coordinates, read as ",
                       columns.size(), " floats a point; --columns names them, if it is a sweep"));
  }
  std::vector<NamedField> fields;
  for (std::size_t i = 0; i < columns.size(); ++i)
    fields.push_back({columns[i], {i * sizeof(float), size, NumberType::float32}});
  const RecordLayout layout = TRY(layout_of(fields, notes.unread));
  return read_records(source, {0, source.size() / size, size}, layout, notes);
}

}  // namespace pointreel
