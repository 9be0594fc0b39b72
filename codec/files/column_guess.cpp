#include "codec/files/column_guess.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <utility>

#include "common/base/concat.h"

namespace pointreel {
namespace {

using Names = std::vector<std::string>;

void add(Names& names, std::initializer_list<const char*> more) {
  names.insert(names.end(), more.begin(), more.end());
}

Names numbered_up_to(Names names, std::size_t columns) {
  for (std::size_t i = names.size(); i < columns; ++i) names.push_back(concat("column ", i + 1));
  return names;
}

}  // namespace

void ColumnGuess::see(const double* row, std::size_t columns) {
  for (std::size_t i = 3; i < std::min(columns, kMost); ++i) {
    looks_[i].whole &= row[i] >= 0.0 && row[i] == std::floor(row[i]);
    looks_[i].bytes &= row[i] <= 255.0;
    looks_[i].negative |= row[i] < 0.0;
    looks_[i].most = std::max(looks_[i].most, row[i]);
    if (rows_ == 0) looks_[i].first = row[i];
    looks_[i].varies |= row[i] != looks_[i].first;
  }
  for (std::size_t i = 3; i + 3 <= std::min(columns, kMost); ++i) {
    const double length = row[i] * row[i] + row[i + 1] * row[i + 1] + row[i + 2] * row[i + 2];
    looks_[i].unit += std::abs(length - 1.0) < 0.01;
  }
  if (before_) {
    counted_ += row[0] == *before_ + 1.0;
    falls_ |= row[0] <= *before_;
  }
  before_ = row[0];
  ++rows_;
}

bool ColumnGuess::first_counts_rows() const {
  constexpr std::size_t kEnough = 20;
  return rows_ >= kEnough && !falls_ && counted_ * 10 > rows_ * 9;
}

bool ColumnGuess::are_bytes(std::size_t at) const {
  return std::all_of(looks_.begin() + static_cast<std::ptrdiff_t>(at),
                     looks_.begin() + static_cast<std::ptrdiff_t>(at) + 3,
                     [](const Look& look) { return look.whole && look.bytes; });
}

bool ColumnGuess::are_bright_bytes(std::size_t at) const {
  constexpr double kBright = 100.0;
  return are_bytes(at) &&
         std::min({looks_[at].most, looks_[at + 1].most, looks_[at + 2].most}) > kBright;
}

bool ColumnGuess::are_unit(std::size_t at) const { return looks_[at].unit * 10 > rows_ * 9; }

bool ColumnGuess::are_normals(std::size_t at) const {
  return looks_[at].negative || looks_[at + 1].negative || looks_[at + 2].negative || are_unit(at);
}

void ColumnGuess::add_two_triples(Names& names, std::size_t columns) const {
  constexpr std::size_t kFirst = 3, kSecond = 6, kBehindNumber = 7;
  const bool number = columns == kBehindNumber + 3;
  const auto add_number = [&] {
    if (number) add(names, {"intensity"});
  };
  if (are_normals(kFirst)) {
    add(names, {"nx", "ny", "nz"});
    const bool behind = number && are_bytes(kBehindNumber) && !are_bytes(kSecond);
    if (behind) add_number();
    add(names, {"r", "g", "b"});
    if (!behind) add_number();
    return;
  }
  add(names, {"r", "g", "b"});
  if (number && are_unit(kBehindNumber) && !are_unit(kSecond)) add_number();
  if (are_normals(names.size())) add(names, {"nx", "ny", "nz"});
  if (number && names.size() == columns - 1) add_number();
}

Names ColumnGuess::text_names(std::size_t columns, bool pts) const {
  Names names{"x", "y", "z"};
  if (columns == 4) add(names, {"intensity"});
  // .pts files have the intensity first, unless their numbers are none of colours.
  const bool behind_intensity = are_bytes(3) ? are_bytes(4) && pts : are_bytes(4) || pts;
  if (columns == 10 && behind_intensity && are_bytes(4) && are_unit(7))
    return {"x", "y", "z", "intensity", "r", "g", "b", "nx", "ny", "nz"};
  if (columns == 7 && are_unit(4) && !are_unit(3)) {
    add(names, {"intensity", "nx", "ny", "nz"});
  } else if (columns == 7 && behind_intensity) {
    add(names, {"intensity", "r", "g", "b"});
  } else if (columns == 6 || columns == 7) {
    if (are_normals(3) && !(pts && are_bytes(3))) {
      add(names, {"nx", "ny", "nz"});
    } else {
      add(names, {"r", "g", "b"});
    }
    if (columns == 7) add(names, {"intensity"});
  } else if (columns == 9 || columns == 10) {
    add_two_triples(names, columns);
  } else if (columns > 7 && are_bright_bytes(3)) {
    add(names, {"r", "g", "b"});
  } else if (columns > 7 && are_bright_bytes(4)) {
    add(names, {"intensity", "r", "g", "b"});
  }
  return numbered_up_to(std::move(names), columns);
}

Names ColumnGuess::sweep_names(std::size_t floats) const {
  Names names{"x", "y", "z"};
  if (floats == 6 && are_bytes(3)) {
    add(names, {"r", "g", "b"});
  } else if (floats == 6 && are_unit(3)) {
    add(names, {"nx", "ny", "nz"});
  } else if (floats == 7 && are_bytes(4)) {
    add(names, {"intensity", "r", "g", "b"});
  } else {
    if (floats > 3) add(names, {"intensity"});
    const bool ring = looks_[4].whole && looks_[4].bytes;
    // A number that never varies says nothing.
    if (floats > 4) add(names, {!looks_[4].varies ? "_" : ring ? "ring" : "time"});
    if (floats > 5 && ring && !looks_[5].whole) add(names, {"time"});
  }
  return numbered_up_to(std::move(names), floats);
}

}  // namespace pointreel
